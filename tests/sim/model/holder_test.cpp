#include "sim/model/holder.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <numbers>

#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;
using testing::kFibreRadius;
constexpr double kYoung = 72e9, kDensity = 2200;
const double kEI = kYoung * pi * std::pow(kFibreRadius, 4) / 4;

Holder silica(double length, const GravityLaw& gravity = Gravity{}) {
  return elastic_fibre(length, 1e9, {kFibreRadius, kDensity, length}, kYoung, gravity);
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
  const double length = 50e-3,
               load = kDensity * pi * kFibreRadius * kFibreRadius * kStandardGravity;
  const Holder holder = silica(length);
  EXPECT_CLOSE(holder.sag[1], -load * std::pow(length, 4) / (8 * kEI), 1e-10);
  EXPECT_CLOSE(holder.sag[3], load * std::pow(length, 3) / (6 * kEI), 1e-10);
  EXPECT_CLOSE(-holder.sag[1], 0.24e-3, 5e-2) << "a quarter of a millimetre";
}

TEST(ElasticFibre, AxialStiffnessIsInSeriesWithTheGripper) {
  const double length = 10e-3, rod = kYoung * pi * kFibreRadius * kFibreRadius / length;
  const Holder holder =
      elastic_fibre(length, 2 * rod, {kFibreRadius, kDensity, length}, kYoung, {});
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
  const double length = 30e-3,
               load = kDensity * pi * kFibreRadius * kFibreRadius * kStandardGravity;
  const Holder holder = silica(length);
  const double per_moment = 4 / (pi * std::pow(kFibreRadius, 3));
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
  const double area = pi * kFibreRadius * kFibreRadius;
  EXPECT_CLOSE(std::sqrt(modes.eigenvalues()[0]),
               3.5160 * std::sqrt(kEI / (kDensity * area)) / (length * length), 5e-3);
}

TEST(RigidHand, CarriesTheWeightWithoutTilting) {
  const Scene scene = testing::paper();
  EXPECT_CLOSE(scene.world.holder.sag[1], -1.4297e-6 / 0.5, 1e-4);
  EXPECT_EQ(scene.world.holder.sag[3], 0);
}

constexpr double kLoss = 0.08;

Scene ringing(const std::vector<std::string>& more = {}) {
  std::vector<std::string> settings = {
      "laws={}", "fibre.young_GPa=72", "dynamics=inertial", "integrator=bdf2",
      "holder={\"type\":\"elastic_fibre\",\"free_length_mm\":10,\"gripper_stiffness_N_m\":100,"
      "\"loss_factor\":" +
          std::to_string(kLoss) + "}"};
  settings.insert(settings.end(), more.begin(), more.end());
  return testing::paper(settings);
}

// Its first mode, for an end that moves by 1.
Pose first_mode(const Holder& holder) {
  const double w = holder.bending_frequency();
  const Matrix5 free = holder.stiffness - w * w * holder.mass;
  Pose mode = Pose::Zero();
  mode[1] = 1;
  mode[3] = -free(1, 1) / free(1, 3);
  EXPECT_LT(std::abs(free(3, 1) + free(3, 3) * mode[3]), 1e-9 * std::abs(free(3, 1)));
  return mode;
}

TEST(ElasticFibre, BendingFrequencyIsTheLowestOfStiffnessAndMass) {
  const Holder holder = silica(10e-3);
  const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix5> modes(holder.stiffness, holder.mass);
  EXPECT_CLOSE(holder.bending_frequency(), std::sqrt(modes.eigenvalues()[0]), 1e-9);
  EXPECT_CLOSE(
      rigid_hand(0.5, 1e-3, {kFibreRadius, kDensity, 50e-3}, kYoung, {}).bending_frequency(),
      std::sqrt(0.5 / (kDensity * pi * kFibreRadius * kFibreRadius * 50e-3)), 1e-9);
}

// The largest miss, in ten periods, of x'' + eta omega x' + omega^2 x = 0 from rest at 1.
double miss_of_ringing(const char* integrator, int steps_a_period) {
  const World world = ringing({std::string("integrator=") + integrator}).world;
  const double w = world.holder.bending_frequency(), damped = w * std::sqrt(1 - kLoss * kLoss / 4);
  StepResult now(at_rest(world, testing::pose(400e-6, 0, 0)));
  State& state = now.state;
  const Pose hand = state.command, rest = state.tip;
  state.tip += 1e-6 * first_mode(world.holder);
  const double dt = 2 * pi / (w * steps_a_period);
  double worst = 0;
  for (int n = 1; n <= 10 * steps_a_period; ++n) {
    step_on(world, hand, dt, now);
    const double t = n * dt;
    const double expected =
        std::exp(-0.5 * kLoss * w * t) *
        (std::cos(damped * t) + 0.5 * kLoss * w / damped * std::sin(damped * t));
    worst = std::max(worst, std::abs((state.tip - rest)[1] / 1e-6 - expected));
  }
  return worst;
}

TEST(ElasticFibre, RingsAsAClosedFormSaysToTheOrderOfTheMethod) {
  for (const auto& [integrator, order] : {std::pair("backward_euler", 1), {"bdf2", 2}}) {
    const double coarse = miss_of_ringing(integrator, 1000);
    const double fine = miss_of_ringing(integrator, 2000);
    EXPECT_CLOSE(std::log2(coarse / fine), order, 0.1) << integrator;
    EXPECT_LT(fine, order == 2 ? 1e-4 : 0.02) << integrator;
  }
}

// The peaks of a period fall by pi eta, whatever the integrator adds.
TEST(ElasticFibre, LosesPiEtaAPeriod) {
  const World world = ringing().world;
  StepResult now(at_rest(world, testing::pose(400e-6, 0, 0)));
  State& state = now.state;
  const Pose hand = state.command, rest = state.tip;
  state.tip += 1e-6 * first_mode(world.holder);
  const double w = world.holder.bending_frequency() * std::sqrt(1 - kLoss * kLoss / 4);
  const int steps = 4000;
  std::vector<double> y;
  for (int n = 0; n <= 5 * steps; ++n) {
    step_on(world, hand, 2 * pi / (w * steps), now);
    y.push_back((state.tip - rest)[1]);
  }
  const auto from = y.begin() + 3 * steps / 4;
  const double first = *std::max_element(from, from + steps);
  const double fourth = *std::max_element(from + 3 * steps, from + 4 * steps);
  EXPECT_CLOSE(std::log(first / fourth) / 3, pi * kLoss / std::sqrt(1 - kLoss * kLoss / 4), 1e-3);
}

// With the second order what falls also has the step before in it.
TEST(ElasticFibre, DampingOnlyTakesEnergy) {
  for (const auto& [integrator, rise] : {std::pair("backward_euler", 1e-12), {"bdf2", 1e-3}})
    for (const double dt : {1e-6, 1e-5, 1e-3}) {
      const World world = ringing({std::string("integrator=") + integrator}).world;
      StepResult now(at_rest(world, testing::pose(400e-6, 0, 0)));
      State& state = now.state;
      const Pose hand = state.command, rest = state.tip;
      state.tip += testing::pose(0, 2e-6, -1e-6, 3e-4, 1e-4);
      const auto energy = [&](const State& s) {
        const Pose bent = s.tip - rest;
        return 0.5 * bent.dot(world.holder.stiffness * bent) +
               0.5 * s.velocity.dot(world.holder.mass * s.velocity);
      };
      const double first = energy(state);
      double before = first;
      for (int n = 0; n < 500; ++n) {
        step_on(world, hand, dt, now);
        EXPECT_LE(energy(state), before + rise * first) << integrator << " " << dt << " " << n;
        before = energy(state);
      }
    }
}

// It is the bending that is damped, not the motion: a hand that moves evenly drags nothing behind,
// and feels what the damping takes.
TEST(ElasticFibre, DampingIsRelativeToTheHand) {
  const World world = ringing().world;
  State state = at_rest(world, testing::pose(400e-6, 0, 0));
  Pose hand = state.command;
  const Pose speed = testing::pose(0, 1e-3, -2e-3, 0.1, 0);
  StepResult r(state);
  for (int n = 0; n < 4000; ++n) {
    hand += 1e-5 * speed;
    r = step(world, state, hand, 1e-5);
    state = r.state;
    if (n != 20) continue;
    const Wrench felt = world.holder.stiffness * (state.tip - hand) +
                        world.holder.damping * (state.velocity - speed);
    EXPECT_LT((r.holder - felt).norm(), 1e-9 * felt.norm());
    EXPECT_GT((world.holder.damping * (state.velocity - speed)).norm(), 1e-3 * felt.norm());
  }
  EXPECT_LT((state.tip - hand - world.holder.sag).head<3>().norm(), 1e-6 * 1e-3);
}

TEST(ElasticFibre, DampingDoesNothingWithoutInertiaAndAtRest) {
  const std::string off = "holder.loss_factor=0";
  for (const char* dynamics : {"dynamics=quasi_static", "dynamics=inertial"}) {
    const World damped = ringing({dynamics}).world, other = ringing({dynamics, off}).world;
    StepResult here(at_rest(damped, testing::pose(-20e-6, 0.2e-6, 0))), there = here;
    const bool moves = damped.dynamics == Dynamics::quasi_static;
    for (int n = 0; n < 200; ++n) {
      const Pose hand = here.state.command + (moves ? 1 : 0) * testing::pose(-1e-8, 1e-8, 0);
      step_on(damped, hand, 1e-3, here);
      step_on(other, hand, 1e-3, there);
      EXPECT_EQ(to_row(here.state), to_row(there.state));
    }
  }
  EXPECT_THROW(ringing({"holder.loss_factor=1.5"}), BadInput);
  EXPECT_THROW(testing::paper({"holder.loss_factor=0.1"}), BadInput);  // a rigid hand
}

}  // namespace
}  // namespace ferrule
