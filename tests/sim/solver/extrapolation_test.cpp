#include "sim/solver/extrapolation.hpp"

#include "sim/solver/follow.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// From in front of the bore along these tips, as they would be without contact, in such steps [m].
std::vector<Pose> hand(const World& world, const std::vector<Pose>& tips, double length) {
  const double c = world.annulus.clearance();
  std::vector<Pose> commands = {testing::pose(5e-6, 0.1 * c, 0) - world.holder.sag};
  for (const Pose& tip : tips) {
    const Pose from = commands.back(), move = tip - world.holder.sag - from;
    const double steps = std::ceil(move.head<3>().norm() / length);
    for (double n = 1; n <= steps; ++n) commands.push_back(from + n / steps * move);
  }
  return commands;
}

// Into the bore, to one wall, along it and half way back while pressed.
std::vector<Pose> hand(const World& world) {
  const double c = world.annulus.clearance();
  return hand(world,
              {testing::pose(-20e-6, 0.1 * c, 0.2 * c), testing::pose(-20e-6, 6 * c, 2 * c),
               testing::pose(-30e-6, 6 * c, 2 * c), testing::pose(-25e-6, 6 * c, 2 * c)},
              20e-9);
}

World with_tangent(double clearances, const char* scene = "bench") {
  WorldParameters p = load_scene(scene).parameters;
  const World world = make_world(p);
  p.numerics.extrapolation_tip = clearances * world.annulus.clearance();
  p.numerics.extrapolation_force = clearances * 60e-6;
  return make_world(p);
}

TEST(Extrapolation, LeavesMostStepsUnsolvedAndIsWhereTheWholeModelIsAfterThem) {
  const World world = with_tangent(1e-3);
  const World full = load_scene("bench", {testing::kEveryStepSolved}).world;
  const std::vector<Pose> commands = hand(world);
  StepResult now(at_rest(world, commands.front() + world.holder.sag));
  const State& state = now.state;
  int solved = 0, off = 0;
  for (const Pose& command : commands) {
    const StepResult exact = step(full, end_extrapolation(world, now), command, 1e-3);
    step_on(world, command, 1e-3, now);
    solved += now.evaluations > 0;
    const double miss = (exact.state.tip - state.tip).head<3>().norm();
    off += miss > 0.01 * world.annulus.clearance();
    EXPECT_EQ(state.command, command);
    EXPECT_TRUE(now.holder.isApprox(world.holder.stiffness * (state.tip - command)));
  }
  EXPECT_LT(solved, static_cast<int>(commands.size() / 3));
  EXPECT_LE(off, static_cast<int>(commands.size() / 20));
}

// Lying in the bore and on its mouth, another point of the fibre rubs there in every step.
TEST(Extrapolation, AlongTheMouthItComesAsNearToTheWholeModelAsItIsAsked) {
  for (const char* scene : {"bench", "adhesive"})
    for (const double clearances : {1e-3, 1e-5}) {
      const World world = with_tangent(clearances, scene);
      const World full = load_scene(scene, {testing::kEveryStepSolved}).world;
      const double c = world.annulus.clearance();
      const std::vector<Pose> commands = hand(world,
                                              {testing::pose(-20e-6, 0.1 * c, 0.2 * c),
                                               testing::pose(-20e-6, 3 * c, -2 * c, -5e-4, -5e-4),
                                               testing::pose(-60e-6, 3 * c, -2 * c, -5e-4, -5e-4)},
                                              4e-9);
      StepResult now(at_rest(world, commands.front() + world.holder.sag)), whole = now;
      const State& state = now.state;
      int both = 0, after = 0, many = 0;
      double miss = 0;
      for (const Pose& command : commands) {
        const bool follows = now.warm_start.extrapolation.has_value();
        both += state.contact[kEnd].closed && state.contact[kSide].closed;
        step_on(world, command, 1e-3, now);
        step_on(full, command, 1e-3, whole);
        after += follows && now.evaluations > 0;
        many += follows && now.evaluations > 3;
        miss = std::max(miss, (state.tip - whole.state.tip).head<3>().norm());
      }
      EXPECT_GT(both, 9000) << scene;
      EXPECT_LT(after, 600) << scene;
      EXPECT_LE(many, 10) << scene;
      EXPECT_LE(miss, 100 * clearances * c) << scene;
    }
}

TEST(Extrapolation, WithoutAWarmStartAStepEndsWithinTheToleranceOfOneWithIt) {
  for (const char* scene : {"bench", "epoxy", "adhesive"}) {
    const World world = load_scene(scene).world;
    const std::vector<Pose> commands = hand(world);
    StepResult now(at_rest(world, commands.front() + world.holder.sag));
    int extrapolated = 0, off = 0;
    for (const Pose& command : commands) {
      const StepResult alone = step(world, state_of(to_row(now.state)), command, 1e-3);
      step_on(world, command, 1e-3, now);
      EXPECT_FALSE(alone.extrapolated());
      extrapolated += now.extrapolated();
      const double miss =
          (alone.state.tip - now.state.tip).head<3>().norm() / world.annulus.clearance();
      off += miss > 1e-4;
    }
    EXPECT_LE(off, 1) << scene << ": but for an event on its brink";
    EXPECT_GT(extrapolated, 1000) << scene;
  }
}

// Of scenes that do not state it to 1e-5 of the clearance and the force limit, with drag too: less
// than half of the steps are solved, where events are few, and the end is where the whole model is.
TEST(Extrapolation, ByDefaultIsFollowedToAHundredThousandthOfTheClearance) {
  for (const char* name : {"bench", "epoxy", "adhesive", "laser", "hard", "easy"}) {
    const Scene scene = load_scene(name);
    const World& world = scene.world;
    const double c = world.annulus.clearance();
    EXPECT_CLOSE(world.numerics.extrapolation_tip, 1e-5 * c, 1e-12);
    EXPECT_CLOSE(world.numerics.extrapolation_force, 1e-5 * scene.limits.force, 1e-12);
    const World full = load_scene(name, {testing::kEveryStepSolved}).world;
    EXPECT_EQ(full.numerics.extrapolation_tip, 0);
    const std::vector<Pose> commands = hand(world);
    StepResult now(at_rest(world, commands.front() + world.holder.sag)), whole = now;
    std::size_t solved = 0, solved_whole = 0, off = 0;
    for (const Pose& command : commands) {
      step_on(world, command, 1e-3, now);
      step_on(full, command, 1e-3, whole);
      solved += now.evaluations > 0;
      solved_whole += whole.evaluations > 0;
      off += (now.state.tip - whole.state.tip).head<3>().norm() > 1e-2 * c;
      EXPECT_FALSE(whole.warm_start.extrapolation);
    }
    EXPECT_LT(2 * solved, solved_whole) << name;
    EXPECT_LE(off, 2) << name;
  }
}

// All terms are those of the pose reached, in balance with the holder.
TEST(Extrapolation, TermsBalanceTheHolder) {
  int followed = 0, rubbing = 0;
  for (const char* name : {"bench", "epoxy", "adhesive"}) {
    const Scene scene = load_scene(name);
    const std::vector<Pose> commands = hand(scene.world);
    StepResult now(at_rest(scene.world, commands.front() + scene.world.holder.sag));
    for (const Pose& command : commands) {
      step_on(scene.world, command, 1e-3, now);
      if (!now.extrapolated() || ++followed % 7) continue;
      const Breakdown breakdown = forces(scene.world, now);
      const Wrench left = breakdown.sum(now.state.tip) - now.holder;
      EXPECT_LT(left.head<3>().norm(), 1e-4 * scene.limits.force) << name;
      rubbing += breakdown.force(Term::friction).norm() > 0;
    }
  }
  EXPECT_GT(rubbing, 30);
}

// A slip that turns: the direction of friction is that of a step.
TEST(Extrapolation, FollowsASlipAroundACorner) {
  const World world = load_scene("bench").world;
  const World full = load_scene("bench", {testing::kEveryStepSolved}).world;
  const double c = world.annulus.clearance();
  StepResult now(at_rest(world, testing::pose(5e-6, 0.1 * c, 0))), whole = now;
  Pose command = now.state.command;
  const auto move = [&](const Pose& by, int steps) {
    int solved = 0;
    for (int n = 0; n < steps; ++n) {
      command += by;
      step_on(world, command, 1e-3, now);
      step_on(full, command, 1e-3, whole);
      solved += now.evaluations > 0;
    }
    return solved;
  };
  move(testing::pose(-10e-9, 0, 0), 3000);     // in
  move(testing::pose(0, 0.005 * c, 0), 1000);  // to the wall
  move(testing::pose(-20e-9, 0, 0), 200);      // it slips along the bore
  ASSERT_TRUE(now.state.contact[kSide].closed);
  int solved = 0;
  for (int n = 0; n < 300; ++n) {
    const double turn = 1e-3 * n;
    solved += move(20e-9 * testing::pose(-std::cos(turn), 0, std::sin(turn)), 1);
  }
  EXPECT_LT(solved, 200);
  EXPECT_LT((now.state.tip - whole.state.tip).head<3>().norm(), 1e-4 * c);
  EXPECT_LT((now.holder - whole.holder).head<3>().norm(), 1e-9);
}

TEST(Extrapolation, IsNotThereWhereItIsNotAskedForOrTimeMatters) {
  const World world = load_scene("bench", {testing::kEveryStepSolved}).world;
  for (const World& w : {world, [&] {
                           World slow = with_tangent(1e-3);
                           slow.dynamics = Dynamics::inertial;
                           return slow;
                         }()}) {
    const std::vector<Pose> commands = hand(w);
    const State start = at_rest(w, commands.front() + w.holder.sag);
    follow(
        w, start, 300, 1e-3,
        [&](std::ptrdiff_t n) { return commands[static_cast<std::size_t>(n)]; },
        [&](std::ptrdiff_t, const StepResult& r) {
          EXPECT_FALSE(r.warm_start.extrapolation);
          return true;
        });
  }
}

}  // namespace
}  // namespace ferrule
