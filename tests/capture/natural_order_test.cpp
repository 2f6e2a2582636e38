#include "capture/natural_order.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace ferrule {
namespace {

TEST(NaturalOrder, CountsDigitsByTheirValue) {
  const std::vector<std::string> sorted = {"",
                                           "a1",
                                           "a01",
                                           "a2b",
                                           "a2b9",
                                           "a2b10",
                                           "a10",
                                           "episode_0001 (1).h5",
                                           "episode_0001 (2).h5",
                                           "episode_0001 (10).h5",
                                           "episode_0001.h5",
                                           "episode_9999.h5",
                                           "episode_10000.h5",
                                           "episode_99999999999999999999.h5",
                                           "episode_100000000000000000000.h5",
                                           "\xc3\xa4"};
  std::vector<std::string> mixed = sorted;
  std::mt19937 chance(1);
  for (int i = 0; i < 20; ++i) {
    std::shuffle(mixed.begin(), mixed.end(), chance);
    std::sort(mixed.begin(), mixed.end(), natural_less);
    EXPECT_EQ(mixed, sorted);
  }
}

TEST(NaturalOrder, IsAnOrder) {
  std::mt19937 chance(2);
  std::vector<std::string> names;
  for (int i = 0; i < 60; ++i) {
    std::string& name = names.emplace_back();
    for (auto k = chance() % 5; k > 0; --k) name += "019a."[chance() % 5];
  }
  for (const std::string& a : names)
    for (const std::string& b : names) {
      EXPECT_EQ(natural_less(a, b) + natural_less(b, a), a != b) << a << " " << b;
      for (const std::string& c : names)
        if (natural_less(a, b) && natural_less(b, c)) {
          EXPECT_TRUE(natural_less(a, c)) << a << " " << b << " " << c;
        }
    }
}

}  // namespace
}  // namespace ferrule
