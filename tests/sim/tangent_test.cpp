#include "sim/tangent.hpp"

#include "sim/follow.hpp"
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
  p.numerics.tangent_tip = clearances * world.annulus.clearance();
  p.numerics.tangent_force = clearances * 60e-6;
  return make_world(p);
}

TEST(Tangent, LeavesMostStepsUnsolvedAndIsWhereTheWholeModelIsAfterThem) {
  const World world = with_tangent(1e-3), full = load_scene("bench").world;
  const std::vector<Pose> commands = hand(world);
  State state = at_rest(world, commands.front() + world.holder.sag);
  int solved = 0, off = 0;
  for (const Pose& command : commands) {
    State here = state;
    leave_tangent(world, here);
    const StepResult exact = step(full, here, command, 1e-3);
    const StepResult followed = step(world, state, command, 1e-3);
    state = followed.state;
    solved += followed.evaluations > 0;
    const double miss = (exact.state.tip - state.tip).head<3>().norm();
    off += miss > 0.01 * world.annulus.clearance();
    EXPECT_EQ(state.command, command);
    EXPECT_TRUE(followed.forces.holder.isApprox(world.holder.stiffness * (state.tip - command)));
  }
  EXPECT_LT(solved, static_cast<int>(commands.size() / 3));
  EXPECT_LE(off, static_cast<int>(commands.size() / 20));
}

// Lying in the bore and on its mouth, another point of the fibre rubs there in every step.
TEST(Tangent, AlongTheMouthItComesAsNearToTheWholeModelAsItIsAsked) {
  for (const char* scene : {"bench", "adhesive"})
    for (const double clearances : {1e-3, 1e-5}) {
      const World world = with_tangent(clearances, scene), full = load_scene(scene).world;
      const double c = world.annulus.clearance();
      const std::vector<Pose> commands = hand(world,
                                              {testing::pose(-20e-6, 0.1 * c, 0.2 * c),
                                               testing::pose(-20e-6, 3 * c, -2 * c, -5e-4, -5e-4),
                                               testing::pose(-60e-6, 3 * c, -2 * c, -5e-4, -5e-4)},
                                              4e-9);
      State state = at_rest(world, commands.front() + world.holder.sag), whole = state;
      int both = 0, after = 0, many = 0;
      double miss = 0;
      for (const Pose& command : commands) {
        const bool follows = state.tangent.has_value();
        both += state.contact[kEnd].closed && state.contact[kSide].closed;
        const StepResult next = step(world, state, command, 1e-3);
        state = next.state;
        whole = step(full, whole, command, 1e-3).state;
        after += follows && next.evaluations > 0;
        many += follows && next.evaluations > 3;
        miss = std::max(miss, (state.tip - whole.tip).head<3>().norm());
      }
      EXPECT_GT(both, 9000) << scene;
      EXPECT_LT(after, 600) << scene;
      EXPECT_LE(many, 10) << scene;
      EXPECT_LE(miss, 100 * clearances * c) << scene;
    }
}

// Free in front of the bore, along stretches and at events, refused commands between them.
TEST(Tangent, AStepInPlaceIsTheSameStep) {
  const World world = with_tangent(1e-3);
  const std::vector<Pose> commands = hand(world);
  State state = at_rest(world, commands.front() + world.holder.sag);
  StepResult now(state);
  int followed = 0;
  for (std::size_t n = 0; n < commands.size(); ++n) {
    const bool refused = n % 100 == 99;
    const Pose command = refused ? Pose(commands[n] * NAN) : commands[n];
    const StepResult expected = step(world, state, command, 1e-3);
    step_on(world, command, 1e-3, now);
    state = expected.state;
    ASSERT_EQ(to_row(now.state), to_row(state)) << n;
    EXPECT_EQ(now.state.tangent.has_value(), state.tangent.has_value());
    EXPECT_EQ(now.status, expected.status);
    EXPECT_EQ(now.evaluations, expected.evaluations);
    EXPECT_EQ(now.iterations, expected.iterations);
    EXPECT_EQ(now.substeps, expected.substeps);
    EXPECT_EQ(now.halvings, expected.halvings);
    EXPECT_EQ(now.forces.holder, expected.forces.holder);
    if (refused) continue;  // with the forces of a step over no time
    followed += now.substeps == 1 && now.evaluations == 0;
    for (const Term term : kAllTerms)
      EXPECT_EQ(now.forces.force(term), expected.forces.force(term));
  }
  EXPECT_GT(followed, 1000);
}

TEST(Tangent, IsNotThereWhereItIsNotAskedForOrTimeMatters) {
  World world = load_scene("bench").world;
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
          EXPECT_FALSE(r.state.tangent);
          return true;
        });
  }
}

}  // namespace
}  // namespace ferrule
