#include "sim/solver/step.hpp"

#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/terms.hpp"
#include "sim/terms/contact.hpp"
#include "tests/allocations.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using testing::pose;

// Moves the hand from where it is to `to` at `speed` [m/s] in steps of dt.
StepResult drive(const World& world, const State& state, const Pose& to, double speed,
                 double dt = 1e-3) {
  const Pose from = state.command;
  const int steps = std::max(1, static_cast<int>((to - from).head<3>().norm() / (speed * dt)));
  StepResult now(state);
  for (int n = 1; n <= steps; ++n) {
    step_on(world, from + (to - from) * (static_cast<double>(n) / steps), dt, now);
    EXPECT_EQ(now.status, StepStatus::ok) << n;
  }
  return now;
}

TEST(Step, FreeFlightHangsBelowTheHandByWeightOverStiffness) {
  const Scene scene = testing::paper();
  const World& world = scene.world;
  State state = at_rest(world, pose(500e-6, 20e-6, -10e-6));
  const StepResult r = step(world, state, pose(490e-6, 30e-6, 5e-6, 1e-3, -2e-3), 1e-3);
  EXPECT_EQ(r.status, StepStatus::ok);
  EXPECT_CLOSE(30e-6 - r.state.tip[1], weight(world.laws.gravity, world.fibre) / 0.5, 1e-9);
  EXPECT_CLOSE(r.state.tip[0], 490e-6, 1e-12);
  EXPECT_CLOSE(r.state.tip[4], -2e-3, 1e-12);
  EXPECT_CLOSE(r.holder[1], -weight(world.laws.gravity, world.fibre), 1e-9);
}

// In the opening of the bore too, where nothing but the weight acts on the way.
TEST(Step, HangsInTheOpeningWhereNothingActs) {
  const std::vector<std::vector<std::string>> ends = {
      {},
      {"fibre.cleave_deg=2"},
      {"fibre.edge_um=4"},
      {"ferrule.ovality_um=0.3"},
      {"ferrule.lead_in=null"},
      {"laws.adhesion.work_of_adhesion_J_m2=0.5", "laws.adhesion.maugis_lambda=0.02"}};
  RandomStream random(21, 0, Draw::start);
  const auto within = [&](double from, double to) { return from + (to - from) * random.uniform(); };
  for (const auto& settings : ends) {
    const World world = load_scene("bench", settings).world;
    const double opening = world.profile.lead_in_length * world.profile.lead_in_tangent;
    int hangs = 0, solved = 0;
    for (int k = 0; k < 400; ++k) {
      std::array<Pose, 2> tip;
      for (Pose& p : tip) {
        const double x = within(-0.3e-6, std::max(2e-6, 0.1 * world.profile.lead_in_length));
        const double wide = world.annulus.clearance() + std::min(x / 2e-5, 1.0) * 0.1 * opening;
        p = pose(x, within(-wide, wide), within(-wide, wide), within(-3e-3, 3e-3),
                 within(-3e-3, 3e-3));
      }
      const State state = at_rest(world, tip[0]);
      const Pose command = tip[1] - world.holder.sag;
      const StepResult r = step(world, state, command, 1e-3);
      if (r.evaluations > 0) {
        ++solved;
        continue;
      }
      ++hangs;
      EXPECT_EQ(r.status, StepStatus::ok);
      EXPECT_TRUE(r.state.tip.isApprox(tip[1], 1e-12));
      for (const double part : {0.0, 0.3, 0.7, 1.0}) {
        State there = state;
        there.tip = tip[0] + part * (tip[1] - tip[0]);
        const FrozenCoefficients frozen = freeze(world, there, command, 1e-3);
        const Potential potential(world, frozen, there.tip);
        EXPECT_EQ(potential.bore.gradient.full(), Pose::Zero()) << k << " " << part;
        EXPECT_EQ(potential.bore.hessian.full(), Matrix5::Zero()) << k << " " << part;
        const Contacts now = contacts(world, frozen, there.tip, potential);
        EXPECT_FALSE(now.contact[kEnd].closed || now.contact[kSide].closed);
      }
    }
    EXPECT_GT(hangs, 10) << settings.size();
    EXPECT_GT(solved, 10);
  }
}

TEST(Step, EndsWhereTheHolderBalancesAllOtherForces) {
  for (const bool solved : {true, false}) {
    const Scene scene =
        solved ? load_scene("paper", {testing::kEveryStepSolved}) : testing::paper();
    const double most = solved ? 1e-6 : 1e-4;  // of all forces
    StepResult r(draw_start(scene, 5, 1));
    for (int n = 0; n < 6000; ++n) {
      Pose hand = r.state.command;
      hand[0] -= 8e-9;
      step_on(scene.world, hand, 1e-3, r);
      ASSERT_EQ(r.status, StepStatus::ok) << n;
      const Breakdown breakdown = forces(scene.world, r);
      const Wrench left = breakdown.sum(r.state.tip) - r.holder;
      double scale = 1e-9;
      for (const Term term : kAllTerms) scale += breakdown.force(term).norm();
      EXPECT_LT(left.head<3>().norm(), most * scale) << n;
    }
    EXPECT_LT(r.state.tip[0], -5e-6);
  }
}

// Brute force: no pose around the result has less energy.
TEST(Step, ResultIsALocalMinimumOfThePotential) {
  const Scene scene = testing::paper({testing::kEveryStepSolved});
  State state = draw_start(scene, 5, 2);
  for (int n = 0; n < 7000; ++n) {
    Pose hand = state.command;
    hand[0] -= 8e-9;
    const FrozenCoefficients frozen = freeze(scene.world, state, hand, 1e-3);
    const StepResult r = step(scene.world, state, hand, 1e-3);
    if (n % 500 == 499 && r.substeps == 1) {
      const double value = Potential(scene.world, frozen, r.state.tip).value;
      RandomStream random(9, static_cast<std::uint64_t>(n), Draw::start);
      for (int k = 0; k < 200; ++k) {
        Pose near = r.state.tip;
        const double reach = 1e-9 * random.uniform();
        for (int i = 0; i < 5; ++i) near[i] += (i < 3 ? 1 : 1e4) * reach * random.normal();
        const Potential there(scene.world, frozen, near);
        EXPECT_GE(there.value, value - 1e-14 * there.value_scale);
      }
    }
    state = r.state;
  }
}

TEST(Step, ABoreTakesExactlyTheFibresWithinItsClearance) {
  const Scene scene = testing::bare({"holder.tilt_stiffness_N_m_rad=1e6"});
  const double c = scene.world.annulus.clearance();
  for (const double offset : {0.5, 0.9, 0.98, 0.999, 1.001, 1.02, 1.1, 3.0, 30.0})
    for (int k = 0; k < 8; ++k)
      for (const double speed : {5e-6, 50e-6})
        for (const double dt : {1e-4, 1e-3, 1e-2}) {
          const double angle = k * std::acos(-1) / 4;
          const double y = offset * c * std::cos(angle), z = offset * c * std::sin(angle);
          const State start = at_rest(scene.world, pose(0.3e-6, y, z));
          const State end = drive(scene.world, start, pose(-3e-6, y, z), speed, dt).state;
          EXPECT_EQ(end.tip[0] < -2.9e-6, offset < 1) << offset << " " << k << " " << dt;
        }
}

TEST(Step, ALeadInGathersExactlyTheFibresWithinItsRim) {
  const Scene scene = testing::paper({"laws={}", "holder.tilt_stiffness_N_m_rad=1e6"});
  const FerruleProfile& profile = scene.world.profile;
  const double reach = profile.mouth_radius() - scene.world.annulus.fibre_radius;
  for (const double part : {0.2, 0.9, 0.999, 1.001, 1.1}) {
    const double y = part * reach * std::cos(1.0), z = part * reach * std::sin(1.0);
    const double x = profile.lead_in_length;
    const State start = at_rest(scene.world, pose(x + 1e-6, y, z));
    // The holder is soft: it must push further than the offset to slide down the cone.
    const State end = drive(scene.world, start, pose(-x - 20e-6, y, z), 50e-6).state;
    EXPECT_EQ(end.tip[0] < -1e-6, part < 1) << part;
  }
}
// On the bore's axis surface forces push neither way, but their potential curves down steeply
// there. That must not keep the fibre from following the hand along the axis.
TEST(Step, AFibreOnTheAxisFollowsTheHandIn) {
  const World world = testing::paper().world;
  State state = at_rest(world, testing::pose(5e-6, 0, 0));
  const Pose from = state.command;
  for (int n = 1; n <= 2000; ++n) {
    const StepResult r = step(world, state, from + testing::pose(-27.5e-9 * n, 0, 0), 1e-3);
    ASSERT_EQ(r.status, StepStatus::ok) << n;
    state = r.state;
  }
  EXPECT_LT(std::abs(state.tip[0] + 50e-6), 1e-12);
}

// Pressed against the rim of the mouth and pulled out: the end cuts the side's contact, which ends
// there without a jump of its energy. (In the printed well of millions of newtons per micrometre
// some steps end at rounding.)
TEST(Step, AFibrePulledOutAlongAWallSlidesOffTheRim) {
  for (const char* name : {"paper", "dry", "demo"})
    for (const double aside : {-17e-6, -3e-6, 5e-6}) {
      const World world = load_scene(name).world;
      State state = at_rest(world, testing::pose(20e-6, 0.1e-6, 0));
      int stuck = 0;
      const auto go = [&](double x, double y, int steps) {
        const Pose from = state.command;
        for (int n = 1; n <= steps; ++n) {
          const Pose move = testing::pose(x * n / steps, y * n / steps, 0);
          const StepResult r = step(world, state, from + move, 1e-3);
          stuck += r.status != StepStatus::ok;
          state = r.state;
        }
      };
      go(-60e-6, 0, 2000);
      go(0, aside, 1000);
      ASSERT_TRUE(state.contact[kSide].closed) << name << " " << aside;
      go(100e-6, 0, 4000);
      EXPECT_LE(stuck, 50) << name << " " << aside;
      EXPECT_GT(state.tip[0], 50e-6) << name << " " << aside;
    }
}

TEST(Step, AHandThatJumpsTenCentimetresIsStoppedByTheFace) {
  const Scene scene = testing::paper();
  const State start = at_rest(scene.world, pose(150e-6, 80e-6, 0));
  const double jump = 0.1 / 250;
  const StepResult r = step(scene.world, start, pose(150e-6 - jump, 80e-6, 0), 1e-3);
  EXPECT_EQ(r.status, StepStatus::ok);
  // Pressed 10 nm and a little into the face, not through it.
  EXPECT_NEAR(r.state.tip[0] * 1e6, scene.world.profile.lead_in_length * 1e6, 0.1);
  EXPECT_EQ(r.state.side, EdgeSide::face);
}

// Each Newton step that knows only where it begins leaps between the friction of a contact that
// opens and the walls on both sides: hundreds of evaluations.
TEST(Step, IsBoundedWhateverTheHandDoes) {
  for (const char* name : {"bench", "demo", "sticky", "paper"}) {
    const Scene scene = load_scene(name, {"ferrule.bore_diameter_um=125.136"});  // 68 nm
    RandomStream random(3, 1, Draw::operator_hand);
    State state = draw_start(scene, 3, 1);
    for (int n = 0; n < 400; ++n) {
      Pose hand = state.command;
      hand[0] += n % 2 ? -166e-6 * random.uniform() : 100e-6 * random.uniform();
      hand[1] += 20e-6 * random.normal();
      hand[2] += 20e-6 * random.normal();
      hand = hand.cwiseMax(-300e-6).cwiseMin(300e-6);
      const StepResult r = step(scene.world, state, hand, 1e-3);
      EXPECT_LE(r.evaluations, SolverParameters{}.max_evaluations) << name << " " << n;
      EXPECT_TRUE(to_row(r.state).allFinite()) << name << " " << n;
      EXPECT_EQ(r.state.command, hand) << name << " " << n;
      state = r.state;
    }
  }
}

// What one call could not do the next ones do.
TEST(Step, GoesOnWhereTheLastOneWasCapped) {
  const Scene scene = load_scene("bench", {"ferrule.bore_diameter_um=125.136"});
  StepResult r(draw_start(scene, 4, 1));
  for (const double x : {-50e-6, 120e-6, -80e-6}) {
    Pose hand = r.state.command;
    hand[0] = x;
    hand[1] += 60e-6;
    for (int n = 0; n < 200; ++n) step_on(scene.world, hand, 1e-3, r);
    EXPECT_EQ(r.status, StepStatus::ok) << x;
    EXPECT_LE(r.evaluations, 2) << x;
  }
}

TEST(Step, AFibreTiltedOnTheFaceFeelsNoForcesOfTheBore) {
  // Beside a sharp bore, leaning so that the centre of its end is below the entrance plane.
  const Scene scene =
      testing::paper({"ferrule.lead_in=null", "roughness_nm=5", "laws.van_der_waals.form=corrected",
                      "laws.electrostatic.form=corrected", "laws.capillary.form=corrected",
                      "laws.adhesion.form=corrected", "laws.friction.form=corrected",
                      "laws.meniscus={\"form\":\"corrected\",\"surface_tension_N_m\":0.05,"
                      "\"contact_angle_deg\":30}"});
  const double beside = 5 * scene.world.annulus.clearance();
  const State start = at_rest(scene.world, pose(2e-6, beside, 0, -0.02, 0));
  Pose pressed = start.command;
  pressed[0] = -5e-6;
  const StepResult r = drive(scene.world, start, pressed, 20e-6);
  EXPECT_EQ(r.state.side, EdgeSide::face);
  EXPECT_LT(r.state.tip[0], 0);
  EXPECT_TRUE(r.state.contact[kEnd].closed);
  for (const Term term :
       {Term::van_der_waals, Term::electrostatic, Term::capillary, Term::meniscus})
    EXPECT_EQ(forces(scene.world, r).force(term).norm(), 0) << static_cast<int>(term);
  EXPECT_NEAR(1e6 * r.state.tip[1], 1e6 * beside, 0.5);
}

TEST(Step, AHandThatJumpsSidewaysInTheBoreIsHeldByTheWall) {
  const Scene scene = testing::bare();
  State start =
      drive(scene.world, at_rest(scene.world, pose(1e-6, 0, 0)), pose(-50e-6, 0, 0), 50e-6).state;
  const StepResult r = step(scene.world, start, pose(-50e-6, 400e-6, 0), 1e-3);
  EXPECT_EQ(r.status, StepStatus::ok);
  EXPECT_LT(r.state.tip[1], 0.6e-6);
  EXPECT_GT(r.state.tip[1], 0.5e-6);
}

TEST(Step, AFibreThatStartsInTheWallIsPushedOut) {
  const Scene scene = testing::bare();
  const double c = scene.world.annulus.clearance();
  State start;
  start.tip = pose(-20e-6, c + 300e-9, 0);
  start.command = pose(-20e-6, 0, 0);
  const StepResult r = step(scene.world, start, start.command, 1e-3);
  EXPECT_EQ(r.status, StepStatus::ok);
  EXPECT_LT(r.state.tip[1], c);
}

TEST(Step, BadCommandsLeaveTheStateUnchanged) {
  const Scene scene = testing::paper();
  const State state = draw_start(scene, 1, 1);
  for (const double bad : {double(NAN), double(INFINITY)})
    for (int i = 0; i < 5; ++i) {
      Pose hand = state.command;
      hand[i] = bad;
      const StepResult r = step(scene.world, state, hand, 1e-3);
      EXPECT_EQ(r.status, StepStatus::bad_command);
      EXPECT_EQ(to_row(r.state), to_row(state));
    }
  EXPECT_EQ(step(scene.world, state, state.command, -1e-3).status, StepStatus::bad_command);
  EXPECT_EQ(step(scene.world, state, state.command, NAN).status, StepStatus::bad_command);
}

TEST(StepAtLength, AHandAtRestForAMillionStepsDoesNotDrift) {
  const Scene scene = testing::paper();
  StepResult now(draw_start(scene, 2, 3));
  State& state = now.state;
  Pose hand = state.command;
  for (int n = 0; n < 6000; ++n) {
    hand[0] -= 8e-9;
    step_on(scene.world, hand, 1e-3, now);
  }
  for (int n = 0; n < 1000; ++n) step_on(scene.world, hand, 1e-3, now);
  const Pose settled = state.tip;
  for (int n = 0; n < 1000000; ++n) step_on(scene.world, hand, 1e-3, now);
  EXPECT_LT((state.tip - settled).head<3>().norm(), 1e-15);
  EXPECT_LT((state.tip - settled).tail<2>().norm(), 1e-12);
}

TEST(Step, PrintedSingularLawsSnapInFromAHundredNanometres) {
  const Scene scene = testing::paper();
  const double c = scene.world.annulus.clearance();
  State state;
  state.tip = state.command = pose(-50e-6, -(c - 100e-9), 0);
  state.command[1] += 5e-6;
  for (int n = 0; n < 2000; ++n) {
    Pose hand = state.command;
    hand[1] -= 10e-9;
    const StepResult r = step(scene.world, state, hand, 1e-3);
    ASSERT_EQ(r.status, StepStatus::ok) << n;
    ASSERT_TRUE(r.state.tip.allFinite());
    state = r.state;
  }
  EXPECT_TRUE(state.contact[kEnd].closed);
}

// Along the bore a contact sticks, then slips at the Hurtado-Kim force.
TEST(Step, FrictionSticksAndThenSlipsAtItsLimit) {
  const Scene scene = testing::paper({"laws.van_der_waals=null", "laws.electrostatic=null",
                                      "laws.capillary=null", "laws.gravity=null"});
  const World& world = scene.world;
  StepResult now;
  State& state = now.state;
  state.tip = pose(-20e-6, -world.annulus.clearance() - 10.1e-9, 0, 2e-3, 0);
  state.command = state.tip;
  for (int n = 0; n < 5; ++n) step_on(world, Pose(state.command), 1e-3, now);
  ASSERT_TRUE(state.contact[kEnd].closed);
  const double x0 = state.tip[0];
  const double limit = friction(*friction_law(world.laws), printed::contact_radius(10e-9));
  // Half the limit: the tip moves by limit/2k_t, some 0.1 nm.
  Pose hand = state.command;
  hand[0] -= 0.5 * limit / 0.5;
  StepResult held_now = now;
  const State& held = held_now.state;
  step_on(world, hand, 1e-3, held_now);
  EXPECT_LT(std::abs(held.tip[0] - x0), 0.2e-9);
  const double creep_from = held.tip[0];
  for (int n = 0; n < 10000; ++n) step_on(world, hand, 1e-3, held_now);
  EXPECT_LT(std::abs(held.tip[0] - creep_from), 1e-15) << "a held load must not creep";
  // Beyond: it slides and lags behind by limit/k.
  const StepResult slid = drive(world, state, pose(-30e-6, state.command[1], 0, 2e-3, 0), 8e-6);
  EXPECT_CLOSE(slid.state.tip[0] - slid.state.command[0], limit / 0.5, 1e-3);
  EXPECT_CLOSE(forces(world, slid)[Term::friction][kEnd].force.x(), limit, 1e-3);
}

TEST(Step, DoesNotAllocate) {
  const Scene scene = testing::paper();
  StepResult now(draw_start(scene, 2, 4));
  State& state = now.state;
  const std::size_t before = testing::allocations();
  for (int n = 0; n < 7000; ++n) {
    Pose hand = state.command;
    hand[0] -= 8e-9;
    step_on(scene.world, hand, 1e-3, now);
  }
  EXPECT_EQ(testing::allocations(), before);
  EXPECT_LT(state.tip[0], 0) << "the motion must have reached the bore";
}

// Random hands, jumps of up to a tenth of a millimetre in a step and stalls among them: always
// finite, mostly converged, the rest where the evaluations are spent.
TEST(Step, AlwaysReturnsSomethingFinite) {
  int not_converged = 0, capped = 0, steps = 0;
  for (std::uint64_t k = 0; k < 24; ++k) {
    const Scene scene = k % 2 ? testing::paper() : testing::bare();
    RandomStream random(11, k, Draw::operator_hand);
    StepResult r(draw_start(scene, 11, k));
    for (int n = 0; n < 150; ++n, ++steps) {
      Pose hand = r.state.command;
      const double reach = std::pow(10.0, -9 + 5 * random.uniform());
      for (int i = 0; i < 3; ++i) hand[i] += reach * random.normal();
      for (int i = 3; i < 5; ++i) hand[i] += 10 * reach * random.normal();
      hand = hand.cwiseMax(-1e-3).cwiseMin(1e-3);
      step_on(scene.world, hand, std::pow(10.0, -6 + 5 * random.uniform()), r);
      ASSERT_TRUE(to_row(r.state).allFinite());
      ASSERT_TRUE(r.holder.allFinite());
      not_converged += r.status == StepStatus::not_converged;
      capped += r.status == StepStatus::iteration_limit;
    }
  }
  EXPECT_LT(not_converged, steps / 200);
  EXPECT_LT(capped, steps / 20);
}

}  // namespace
}  // namespace ferrule
