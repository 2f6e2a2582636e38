#include "sim/holder.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <numbers>

#include "sim/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double kYoung = 72e9, kRadius = 62.5e-6, kDensity = 2200;
const double kEI = kYoung * pi * std::pow(kRadius, 4) / 4;

Holder silica(double length, const GravityLaw& gravity = Gravity{}) {
  return elastic_fibre(length, 1e9, {kRadius, kDensity, length}, kYoung, gravity);
}

TEST(ElasticFibre, HasTheStiffnessOfACantilever) {
  EXPECT_CLOSE(kEI, 8.63e-7, 1e-3);
  for (const auto& [length, stiffness] :
       {std::pair(3e-3, 96.0), {5e-3, 20.7}, {10e-3, 2.6}, {20e-3, 0.32}}) {
    // A force at the end, without moment: 3 E I/L^3.
    Wrench force = Wrench::Zero();
    force[1] = 1e-6;
    const Pose bent = silica(length).stiffness.llt().solve(force);
    EXPECT_CLOSE(1e-6 / bent[1], 3 * kEI / std::pow(length, 3), 1e-10);
    EXPECT_CLOSE(1e-6 / bent[1], stiffness, 2e-2);
    // The slope falls towards the gripper: -F L^2/(2 E I) along x.
    EXPECT_CLOSE(bent[3], -1e-6 * length * length / (2 * kEI), 1e-10);
  }
}

TEST(ElasticFibre, SagsUnderItsWeightToTheClosedForm) {
  const double length = 50e-3, load = kDensity * pi * kRadius * kRadius * kStandardGravity;
  const Holder holder = silica(length);
  EXPECT_CLOSE(holder.sag[1], -load * std::pow(length, 4) / (8 * kEI), 1e-10);
  EXPECT_CLOSE(holder.sag[3], load * std::pow(length, 3) / (6 * kEI), 1e-10);
  EXPECT_CLOSE(-holder.sag[1], 0.24e-3, 5e-2) << "a quarter of a millimetre";
}

TEST(ElasticFibre, AxialStiffnessIsInSeriesWithTheGripper) {
  const double length = 10e-3, rod = kYoung * pi * kRadius * kRadius / length;
  const Holder holder = elastic_fibre(length, 2 * rod, {kRadius, kDensity, length}, kYoung, {});
  EXPECT_CLOSE(holder.stiffness(0, 0), rod * 2 / 3, 1e-12);
}

TEST(ElasticFibre, EulerLoadAndBendingStress) {
  for (const auto& [length, load] :
       {std::pair(3e-3, 237e-3), {5e-3, 85e-3}, {10e-3, 21e-3}, {20e-3, 5.3e-3}})
    EXPECT_CLOSE(silica(length).euler_load, load, 2e-2);
  // Pure bending to a radius of 6.5 mm is at the proof stress of 0.69 GPa.
  const Holder holder = silica(10e-3, GravityLaw{});
  Wrench moment = Wrench::Zero();
  moment[3] = kEI / 6.5e-3;
  const Pose tip = holder.stiffness.llt().solve(moment);
  EXPECT_CLOSE(holder.bending_stress(tip, Pose::Zero()), 0.69e9, 1e-2);
}

// Its own weight q per length bends a cantilever by q L^2/2 at the gripper, and not at the end; a
// force F at the end adds F L there.
TEST(ElasticFibre, BendingStressOfItsWeightIsThatOfTheClosedForm) {
  const double length = 30e-3, load = kDensity * pi * kRadius * kRadius * kStandardGravity;
  const Holder holder = silica(length);
  const double per_moment = 4 / (pi * std::pow(kRadius, 3));
  const double moment = 0.5 * load * length * length;
  EXPECT_CLOSE(holder.bending_stress(holder.sag, Pose::Zero()), moment * per_moment, 1e-9);
  Wrench force = Wrench::Zero();
  force[1] = -3e-6;
  const Pose bent = holder.sag + holder.stiffness.llt().solve(force);
  EXPECT_CLOSE(holder.bending_stress(bent, Pose::Zero()), (moment + 3e-6 * length) * per_moment,
               1e-9);
}

// The first bending mode of a clamped-free beam: omega = 3.5160 sqrt(E I/(rho A L^4)).
TEST(ElasticFibre, VibratesAtTheFrequencyOfACantilever) {
  const double length = 10e-3;
  const Holder holder = silica(length, GravityLaw{});
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(
      Eigen::MatrixXd(holder.stiffness), Eigen::MatrixXd(holder.mass));
  const double area = pi * kRadius * kRadius;
  EXPECT_CLOSE(std::sqrt(modes.eigenvalues()[0]),
               3.5160 * std::sqrt(kEI / (kDensity * area)) / (length * length), 5e-3);
}

TEST(RigidHand, CarriesTheWeightWithoutTilting) {
  const Scene scene = testing::paper();
  EXPECT_CLOSE(scene.world.holder.sag[1], -1.4297e-6 / 0.5, 1e-4);
  EXPECT_EQ(scene.world.holder.sag[3], 0);
}

}  // namespace
}  // namespace ferrule
