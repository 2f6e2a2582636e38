#include "sim/laws/wall.hpp"

#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr Wall kHertz = {4.27e10, 62.5e-6, 0};

TEST(Wall, IsHertz) {
  // F = K a^3 / R with a^2 = R d.
  const double d = 3e-9, a = std::sqrt(62.5e-6 * d);
  EXPECT_CLOSE(wall(kHertz, d).force, 4.27e10 * a * a * a / 62.5e-6, 1e-14);
  EXPECT_CLOSE(wall(kHertz, 4 * d).force, 8 * wall(kHertz, d).force, 1e-14);
}

TEST(Wall, DoesNotPushBeforeItBegins) {
  EXPECT_EQ(wall(kHertz, -1e-9).force, 0);
  EXPECT_EQ(wall({4.27e10, 62.5e-6, 10e-9}, 9e-9).force, 0);
  EXPECT_CLOSE(wall({4.27e10, 62.5e-6, 10e-9}, 13e-9).force, wall(kHertz, 3e-9).force, 1e-12);
}

TEST(Wall, ForceAndSlopeAreDerivativesOverDecades) {
  const auto at = [](double d) { return wall(kHertz, d); };
  for (double d = 1e-12; d < 1e-6; d *= 7) testing::expect_derivatives(at, d, 1e-2 * d, 1e-7, +1);
}

}  // namespace
}  // namespace ferrule
