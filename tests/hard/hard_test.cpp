// Every hard case ends right (tests/hard/README.md says what right is).
#include "bench/hard.hpp"

#include <gtest/gtest.h>

namespace ferrule {
namespace {

TEST(HardAtLength, EveryCaseEndsRight) {
  const std::vector<HardRow> rows = bench_hard();
  EXPECT_GE(rows.size(), 20u);
  for (const HardRow& row : rows) {
    EXPECT_TRUE(row.finite) << row.name;
    EXPECT_FALSE(row.gained) << row.name;
    EXPECT_LE(row.error, row.tolerance) << row.name << ": " << row.result;
  }
}

}  // namespace
}  // namespace ferrule
