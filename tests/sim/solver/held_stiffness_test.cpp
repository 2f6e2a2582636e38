#include "sim/solver/held_stiffness.hpp"

#include <Eigen/Eigenvalues>

#include "insertion/stiffness_range.hpp"
#include "sim/base/random.hpp"
#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using Eigen::Matrix3d;

// -dW/dh of one step of dt from `state`, by central differences.
Matrix5 by_stepping(const World& world, const State& state, double dt) {
  Matrix5 K;
  for (int i = 0; i < 5; ++i) {
    const double h = i < 3 ? 0.2e-9 : 0.2e-9 / world.holder.tilt_length;
    Pose move = Pose::Zero();
    move[i] = h;
    const Wrench up = step(world, state, state.command + move, dt).holder;
    const Wrench down = step(world, state, state.command - move, dt).holder;
    K.col(i) = (down - up) / (2 * h);
  }
  return K;
}

// Tilts counted by the length that makes the holder's stiffnesses alike.
Matrix5 scaled(const World& world, Matrix5 K) {
  K.bottomRows<2>() /= world.holder.tilt_length;
  K.rightCols<2>() /= world.holder.tilt_length;
  return K;
}

// A fibre somewhere in the bore, pushed sideways and tilted.
State somewhere(const Scene& scene, std::uint64_t trial) {
  const World& world = scene.world;
  RandomStream random(11, trial, Draw::start);
  const double c = world.annulus.clearance(), depth = (0.2 + 0.8 * random.uniform()) * 50e-6;
  const auto any = [&](double most) { return most * (2 * random.uniform() - 1); };
  StepResult now(at_rest(world, testing::pose(5e-6, 0, 0)));
  State& state = now.state;
  const Pose goal =
      testing::pose(-depth, any(3 * c), any(3 * c), any(4 * c / depth), any(4 * c / depth)) -
      world.holder.sag;
  const Pose from = state.command;
  for (int i = 1; i <= 400; ++i) step_on(world, from + i / 400.0 * (goal - from), 1e-3, now);
  for (int i = 0; i < 5; ++i) step_on(world, goal, 1e3, now);  // drag lets it creep
  return state;
}

TEST(HeldStiffness, IsZeroInFreeAir) {
  for (const char* name : {"paper", "bench"}) {
    const World world = load_scene(name).world;
    const Matrix5 K = held_stiffness(world, at_rest(world, testing::pose(1e-3, 0, 0)));
    EXPECT_LT(scaled(world, K).norm(), 1e-9 * scaled(world, world.holder.stiffness).norm());
  }
}

TEST(HeldStiffness, OfAContactIsHolderAndWallInSeries) {
  const World world = testing::bare().world;
  StepResult now(at_rest(world, testing::pose(5e-6, 0, 0)));
  State& state = now.state;
  // The end leans on the wall with its rim: pushed along y at its own height.
  for (int i = 1; i <= 500; ++i) step_on(world, testing::pose(5e-6 - 0.05e-6 * i, 0, 0), 1e-3, now);
  for (int i = 1; i <= 500; ++i) step_on(world, testing::pose(-20e-6, 5e-9 * i, 0), 1e-3, now);
  ASSERT_TRUE(state.contact[kEnd].closed);
  const double k = world.holder.stiffness(1, 1), K = held_stiffness(world, state)(1, 1);
  EXPECT_LT(K, k);
  EXPECT_CLOSE(K, k, 0.01);
  EXPECT_LT(std::abs(held_stiffness(world, state)(0, 0)), 1e-6 * k) << "smooth along the bore";
}

TEST(HeldStiffness, IsTheDerivativeOfTheStep) {
  int two_point = 0;
  for (const char* name : {"demo", "bench", "epoxy"}) {
    const Scene scene = load_scene(name, {"laws.friction=null"});
    const World& world = scene.world;
    for (std::uint64_t trial = 0; trial < 12; ++trial) {
      const State state = somewhere(scene, trial);
      two_point += state.contact[kEnd].closed && state.contact[kSide].closed;
      for (const double dt : {1e3, 1e-3}) {
        if (dt == 1e-3 && !world.laws.drag) continue;
        const Matrix5 K = scaled(world, held_stiffness(world, state, dt));
        const Matrix5 stepped = scaled(world, by_stepping(world, state, dt));
        EXPECT_LT((K - stepped).norm(), 2e-3 * scaled(world, world.holder.stiffness).norm())
            << name << " " << trial << " " << dt << "\n"
            << K << "\n\n"
            << stepped;
      }
    }
  }
  EXPECT_GT(two_point, 5);
}

TEST(HeldStiffness, IsSymmetricAndNeverMoreThanTheHolder) {
  for (const char* name : {"paper", "demo", "bench", "epoxy", "sticky"}) {
    const Scene scene = load_scene(name);
    const Matrix5 holder = scaled(scene.world, scene.world.holder.stiffness);
    for (std::uint64_t trial = 0; trial < 10; ++trial) {
      const State state = somewhere(scene, trial);
      const Matrix5 K = scaled(scene.world, held_stiffness(scene.world, state));
      EXPECT_LT((K - K.transpose()).norm(), 1e-9 * holder.norm());
      const Eigen::SelfAdjointEigenSolver<Matrix5> modes(holder - K);
      EXPECT_GT(modes.eigenvalues()[0], -1e-9 * holder.norm()) << name << trial;
      const Matrix5 more = scaled(scene.world, held_stiffness(scene.world, state, 1e-3)) - K;
      const Eigen::SelfAdjointEigenSolver<Matrix5> damping(more);
      EXPECT_GT(damping.eigenvalues()[0], -1e-9 * holder.norm()) << name << trial;
    }
  }
}

TEST(HeldStiffness, OfAnInsertionSeesBothContactsInEveryScene) {
  for (const std::string& name : shipped_scenes()) {
    const Scene scene = load_scene(name);
    const StiffnessRange range = insertion_stiffness(scene, 1e-3);
    EXPECT_GT(range.touching, 100u) << name;
    EXPECT_LT(range.touching, range.states) << name;
    // Of about a thousand; in `easy` 9 to 15, by how finely the hand goes there.
    EXPECT_GT(range.two_point, 5u) << name;
    const double holder =
        Eigen::SelfAdjointEigenSolver<Matrix3d>(scene.world.holder.stiffness.topLeftCorner<3, 3>())
            .eigenvalues()[2];
    EXPECT_LE(range.largest, holder * (1 + 1e-9)) << name;
    // Something in the way of a contact is nearly as stiff as the holder itself.
    EXPECT_GT(range.largest, 0.9 * holder) << name;
    const Matrix3d there = held_stiffness(scene.world, range.stiffest).topLeftCorner<3, 3>();
    EXPECT_CLOSE(Eigen::SelfAdjointEigenSolver<Matrix3d>(there).eigenvalues()[2], range.largest,
                 1e-9);
    EXPECT_EQ(range.damping > 0, scene.world.laws.drag.has_value()) << name;
  }
}

TEST(HeldStiffnessInSeconds, OfAnInsertionWithAFarForceLimitIsOfAsManyStates) {
  const Scene scene = load_scene("film", {"limits.force_uN=1e10"});
  const StiffnessRange range = insertion_stiffness(scene, 1e-3);
  EXPECT_LT(range.states, 100'000u);
  EXPECT_GT(range.two_point, 5u);
}

TEST(HeldStiffness, OfAnInsertionSaysHowFarItIsAndCanBeStopped) {
  const Scene scene = load_scene("demo");
  std::vector<std::size_t> seen;
  const StiffnessRange whole =
      insertion_stiffness(scene, 1e-3, [&](std::size_t done, std::size_t all) {
        EXPECT_LE(done, all);
        seen.push_back(all - done);
        return true;
      });
  EXPECT_EQ(seen.back(), 0u);
  const StiffnessRange part =
      insertion_stiffness(scene, 1e-3, [](std::size_t done, std::size_t) { return done < 3; });
  EXPECT_LT(part.states, whole.states / 2);
}

TEST(HeldStiffness, DampingIsThatOfTheDragBehindAStiffHolder) {
  // Drag along x of a centred fibre: coefficient times length, far softer than the gripper.
  const Scene scene = load_scene("epoxy", {"laws.adhesion=null", "laws.friction=null"});
  const World& world = scene.world;
  StepResult now(at_rest(world, testing::pose(2e-6, 0, 0)));
  State& state = now.state;
  const Pose from = state.command;
  for (int i = 1; i <= 400; ++i) step_on(world, from - testing::pose(0.05e-6 * i, 0, 0), 1.0, now);
  const double length = state.inserted_length(), dt = 1e-3;
  const double c =
      drag(*world.laws.drag, world.annulus, state.tip.segment<2>(1).norm(), length).axial;
  const double k = world.holder.stiffness(0, 0);
  const double more = (held_stiffness(world, state, dt) - held_stiffness(world, state))(0, 0);
  EXPECT_CLOSE(dt * more, c * k * dt / (k * dt + c), 0.02);
}

}  // namespace
}  // namespace ferrule
