#include "sim/base/random.hpp"

#include <cmath>
#include <set>

#include "tests/compare.hpp"

namespace ferrule {
namespace {

TEST(RandomStream, DependsOnSeedTrialAndDrawOnly) {
  std::set<std::uint64_t> seen;
  for (std::uint64_t seed : {1u, 2u})
    for (std::uint64_t trial : {0u, 1u, 4'000'000'000u})
      for (const Draw draw : {Draw::start, Draw::operator_hand}) {
        RandomStream a(seed, trial, draw), b(seed, trial, draw);
        for (int i = 0; i < 3; ++i) {
          const std::uint64_t bits = a.bits();
          EXPECT_EQ(bits, b.bits());
          EXPECT_TRUE(seen.insert(bits).second);
        }
      }
}

TEST(RandomStream, HasTheMomentsOfItsDistributions) {
  RandomStream random(5, 0, Draw::start);
  const int n = 200000;
  double u = 0, uu = 0, z = 0, zz = 0, z4 = 0;
  for (int i = 0; i < n; ++i) {
    const double x = random.uniform(), y = random.normal();
    u += x, uu += x * x, z += y, zz += y * y, z4 += y * y * y * y;
  }
  EXPECT_CLOSE(u / n, 0.5, 0.01);
  EXPECT_CLOSE(uu / n, 1.0 / 3, 0.01);
  EXPECT_LT(std::abs(z / n), 0.01);
  EXPECT_CLOSE(zz / n, 1, 0.02);
  EXPECT_CLOSE(z4 / n, 3, 0.05);
}

}  // namespace
}  // namespace ferrule
