#include "bench/peers.hpp"

#include <cmath>

#include "tests/compare.hpp"

namespace ferrule {
namespace {

// The least energy of all poses of a fine grid that are within the bore.
double least_energy(PlanarPose hand, double length, double c, double k, double k_tilt) {
  constexpr int n = 400;
  double least = INFINITY;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j) {
      const double e = c * i / n, tilt = (c * j / n - e) / length;
      least = std::min(least, k * std::pow(e - hand.e, 2) + k_tilt * std::pow(tilt - hand.tilt, 2));
    }
  return least;
}

TEST(Peers, TheReferenceIsTheLeastEnergyWithinTheBore) {
  const double c = 0.5e-6, k = 0.5, k_tilt = 2.4e-7;
  for (const double length : {50e-6, 400e-6})
    for (const double e : {-2e-6, -0.3e-6, 0.0, 0.4e-6, 1.5e-6})
      for (const double tilt : {-5e-3, -1e-3, 0.0, 0.2e-3, 3e-3}) {
        const PlanarPose hand{e, tilt}, p = held_in_bore(hand, length, c, k, k_tilt);
        EXPECT_LE(std::abs(p.e), c * (1 + 1e-6));
        EXPECT_LE(std::abs(p.e + length * p.tilt), c * (1 + 1e-6));
        const double energy = k * std::pow(p.e - e, 2) + k_tilt * std::pow(p.tilt - tilt, 2);
        const double grid = least_energy(hand, length, c, k, k_tilt);
        EXPECT_LE(energy, grid * (1 + 1e-12));
        EXPECT_NEAR(energy, grid, 0.03 * grid + 1e-18) << e << " " << tilt << " " << length;
      }
}

// Ours, which come first; the others, where they are built in, are not what is tested.
TEST(Peers, OursFollowsTheReferenceAndLetsNothingIn) {
  const PeerBench bench = bench_peers([](std::size_t done, std::size_t) { return done < 2; });
  ASSERT_EQ(bench.rows.size(), 2u);
  for (const PeerRow& row : bench.rows) {
    EXPECT_EQ(row.engine, "ferrule");
    EXPECT_LT(row.pose_error_um, 1e-3);  // the walls give by some tenths of a nanometre
    EXPECT_LT(row.force_error_relative, 1e-3);
    EXPECT_LT(row.penetration_um, 1e-3);
    EXPECT_EQ(row.outside, 32);
    EXPECT_EQ(row.let_in, 0);
  }
}

}  // namespace
}  // namespace ferrule
