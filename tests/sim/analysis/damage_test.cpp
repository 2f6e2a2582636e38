#include "sim/analysis/damage.hpp"

#include <cmath>
#include <numbers>

#include "sim/laws/adhesion.hpp"
#include "sim/scene/scene.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;

constexpr double r = 62.5e-6, young = 72e9, poisson = 0.17, length = 0.01, stress = 0.69e9;

DamageForces of(const Scene& scene, double edge) {
  const double K = reduced_modulus(young, poisson, 210e9, 0.3);
  return damage_forces(scene.world, K, poisson, stress, edge);
}

TEST(Damage, OfTheFreeFibreIsEulersLoadAndTheBeamsStress) {
  const DamageForces d = of(load_scene("bench"), 1e-6);
  const double inertia = pi * r * r * r * r / 4;
  EXPECT_CLOSE(d.buckling, pi * pi * young * inertia / (4 * length * length), 1e-9);
  EXPECT_CLOSE(d.bending * length * r / inertia, stress, 1e-12);
  // The simulator's stress (its fibre sags too), of the end pushed aside by that force without
  // tilting moment.
  const World world = load_scene("bench").world;
  Pose tip = Pose::Zero();
  tip[1] = d.bending * length * length * length / (3 * young * inertia);
  tip[3] = -1.5 * tip[1] / length;
  EXPECT_CLOSE(world.holder.bending_stress(tip, Pose::Zero()), stress, 1e-4);
}

TEST(Damage, OfTheEdgeIsHertzs) {
  for (const double edge : {1e-8, 1e-6}) {
    const DamageForces d = of(load_scene("bench"), edge);
    const double modulus = 1 / ((1 - poisson * poisson) / young + (1 - 0.3 * 0.3) / 210e9),
                 R = std::sqrt(edge * r);
    // Mean pressure F/(pi a^2) is two thirds of the largest.
    const double a = std::cbrt(3 * d.ring * R / (4 * modulus));
    const double pressure = 1.5 * d.ring / (pi * a * a);
    EXPECT_CLOSE((1 - 2 * poisson) / 3 * pressure, stress, 1e-9);
    EXPECT_CLOSE(d.chipping, kEdgeToughness * edge, 1e-12);
  }
}

TEST(Damage, ARigidHandNeitherBucklesNorBends) {
  const DamageForces d = of(load_scene("paper"), 1e-6);
  EXPECT_TRUE(std::isinf(d.buckling) && std::isinf(d.bending));
}

}  // namespace
}  // namespace ferrule
