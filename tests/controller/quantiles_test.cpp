#include "controller/quantiles.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "controller/statistics.hpp"
#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

TEST(Quantiles, OfFewNumbersAreExact) {
  Quantiles quantiles;
  EXPECT_TRUE(std::isnan(quantiles(0.5)));
  std::vector<double> all;
  RandomStream random(1, 2, "quantiles");
  for (int i = 0; i < 1000; ++i) {
    all.push_back(random.normal());
    quantiles.add(all.back());
  }
  for (const double p : {0.0, 0.05, 0.5, 0.95, 1.0}) EXPECT_EQ(quantiles(p), quantile(all, p));
}

// From a hundredth of a micronewton to newtons, some of them 0.
TEST(Quantiles, OfManyAreKnownToOnePartInTenThousand) {
  Quantiles quantiles;
  std::vector<double> all;
  RandomStream random(3, 4, "quantiles");
  for (std::size_t i = 0; i < Quantiles::kExact + 100'000; ++i) {
    all.push_back(i % 50 == 0 ? 0.0 : std::pow(10, 8 * random.uniform() - 8));
    quantiles.add(all.back());
  }
  EXPECT_EQ(quantiles.count(), all.size());
  EXPECT_EQ(quantiles(0.01), 0);
  for (const double p : {0.1, 0.5, 0.95, 0.999, 1.0})
    EXPECT_CLOSE(quantiles(p), quantile(all, p), 1.01 * Quantiles::kWithin);
}

}  // namespace
}  // namespace ferrule
