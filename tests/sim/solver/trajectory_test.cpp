// Trajectories against CVODE, the work of closed hand motions, and peg-in-hole theory.
#include "bench/reference.hpp"
#include "sim/solver/step.hpp"
#include "sim/terms/potential.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using testing::pose;

// The paper's scene with all laws corrected.
Scene corrected_scene(std::vector<std::string> settings = {}) {
  for (const char* law :
       {"van_der_waals", "electrostatic", "gravity", "capillary", "adhesion", "friction"})
    settings.insert(settings.begin(), std::string("laws.") + law + ".form=corrected");
  settings.insert(settings.begin(), "roughness_nm=5");
  return testing::paper(settings);
}

double tip_error(const World& world, const State& start, const std::function<Pose(double)>& hand,
                 double duration, double dt) {
  std::vector<double> times;
  for (int n = 1; n <= 20; ++n) times.push_back(duration * n / 20);
  const std::vector<Pose> exact = reference_trajectory(world, start, hand, times);
  State state = start;
  double worst = 0;
  std::size_t next = 0;
  const long steps = std::lround(duration / dt);
  for (long n = 1; n <= steps; ++n) {
    const double t = static_cast<double>(n) * dt;
    const StepResult r = step(world, state, hand(t), dt);
    EXPECT_EQ(r.status, StepStatus::ok);
    state = r.state;
    if (t >= times[next] - 1e-9 * dt)
      worst = std::max(worst, (state.tip - exact[next++]).head<3>().norm());
  }
  return worst;
}

// A fibre in a bore full of adhesive, pushed in and sideways until it lies against the wall.
TEST(Trajectory, AgreesWithCvodeInAdhesiveToFirstOrder) {
  const World world = corrected_scene({"laws.capillary=null", "laws.friction=null",
                                       "laws.drag={\"form\":\"corrected\",\"viscosity_Pa_s\":1}"})
                          .world;
  State start;
  start.tip = pose(-60e-6, 0.1e-6, -0.05e-6, 1e-3, 0.5e-3);
  start.command = start.tip;
  const auto hand = [&](double t) {
    return Pose(start.tip + pose(-8e-6 * t, 0.8e-6 * std::sin(3 * t), 0.5e-6 * t, 0, 1e-3 * t));
  };
  const double coarse = tip_error(world, start, hand, 1, 2e-3);
  const double fine = tip_error(world, start, hand, 1, 1e-3);
  EXPECT_LT(fine, 2e-9) << "at 1 kHz, moving at 8 um/s";
  EXPECT_CLOSE(coarse / fine, 2, 0.2);
}

TEST(Trajectory, AgreesWithCvodeWithInertiaToItsOrder) {
  for (const auto& [method, order] : {std::pair("backward_euler", 1), {"bdf2", 2}}) {
    const World world = testing::paper({"laws={}", "fibre.young_GPa=72", "dynamics=inertial",
                                        std::string("integrator=") + method,
                                        "holder={\"type\":\"elastic_fibre\",\"free_length_mm\":10,"
                                        "\"gripper_stiffness_N_m\":100}"})
                            .world;
    State start = at_rest(world, pose(400e-6, 0, 0));
    const auto hand = [&](double t) {
      const double p = std::min(1.0, t / 2e-3);
      return Pose(start.command + pose(0, 5e-6 * p * p * (3 - 2 * p), 0));
    };
    const double coarse = tip_error(world, start, hand, 4e-3, 2e-6);
    const double fine = tip_error(world, start, hand, 4e-3, 1e-6);
    EXPECT_CLOSE(std::log2(coarse / fine), order, 0.15) << method;
    EXPECT_LT(fine, order == 2 ? 1e-9 : 200e-9);
  }
}

// Backward Euler loses energy at any step and never gains any, however long.
TEST(Trajectory, InertiaIsUnconditionallyStable) {
  for (const char* method : {"backward_euler", "bdf2"})
    for (const double dt : {1e-6, 1e-4, 1e-2, 1.0}) {
      const World world =
          testing::paper({"laws={}", "fibre.young_GPa=72", "dynamics=inertial",
                          std::string("integrator=") + method,
                          "holder={\"type\":\"elastic_fibre\",\"free_length_mm\":10,"
                          "\"gripper_stiffness_N_m\":100}"})
              .world;
      StepResult now(at_rest(world, pose(400e-6, 0, 0)));
      State& state = now.state;
      const Pose rest = state.command;
      state.tip[1] += 5e-6;
      const auto energy = [&](const State& s) {
        const Pose stretch = s.tip - rest;
        return 0.5 * stretch.dot(world.holder.stiffness * stretch) +
               0.5 * s.velocity.dot(world.holder.mass * s.velocity);
      };
      const double at_start = energy(state);
      for (int n = 0; n < 3000; ++n) {
        step_on(world, rest, dt, now);
        ASSERT_LT(energy(state), 1.0001 * at_start) << method << " " << dt << " " << n;
      }
    }
}

// Work of the hand on the fibre in a step: it moves while the fibre holds still, then the fibre
// gives way. Over a closed motion that is what was lost, never less than nothing.
TEST(TrajectoryAtLength, AClosedHandMotionNeverGainsWork) {
  for (const bool friction : {true, false})
    for (const bool liquid : {true, false}) {
      std::vector<std::string> settings;
      if (!friction) settings.push_back("laws.friction=null");
      if (!liquid) settings.push_back("laws.capillary=null");
      const World world = corrected_scene(settings).world;
      // Far enough out for the holder to pull the fibre from the liquid.
      StepResult now(at_rest(world, pose(200e-6, 0, 0)));
      State& state = now.state;
      const Pose origin = state.command;
      double lost = 0, turned = 0;
      const auto drive = [&](const Pose& to, int steps) {
        const Pose from = state.command;
        for (int n = 1; n <= steps; ++n) {
          const Pose hand = from + (to - from) * (static_cast<double>(n) / steps);
          const Pose middle = 0.5 * (state.command + hand);
          const double work =
              -(world.holder.stiffness * (state.tip - middle)).dot(hand - state.command);
          step_on(world, hand, 1e-3, now);
          lost += work;
          turned += std::abs(work);
        }
      };
      for (int loop = 0; loop < 2; ++loop) {
        const double before = lost;
        drive(origin + pose(-60e-6, 0, 0), 6000);                       // in
        drive(origin + pose(-260e-6, 3e-6, 0, 1e-3, 0), 2000);          // against the upper wall
        drive(origin + pose(-270e-6, -3e-6, 1e-6, -1e-3, 2e-3), 4000);  // and the lower one
        drive(origin + pose(-260e-6, 0, 0), 2000);
        drive(origin, 6000);  // and out again
        EXPECT_GE(lost - before, -1e-6 * turned) << friction << liquid << loop;
        EXPECT_FALSE(state.contact[kEnd].closed);
        EXPECT_FALSE(state.bridge);
      }
      EXPECT_GT(lost, 0) << "snap-in, pull-off and friction lose something";
    }
}

// Whitney 1982: a peg tilted by theta touches at two points from the depth on where
// l theta = 2 c (clearance on the diameter over tilt, small angles).
TEST(PegInHole, TouchesAtTwoPointsWhereWhitneySays) {
  const World world = testing::bare({"holder.tilt_stiffness_N_m_rad=1e4"}).world;
  const double c = world.annulus.clearance();
  for (const double tilt : {8e-3, 20e-3, 40e-3}) {
    // The end enters low, so that the side meets the upper rim.
    StepResult now(at_rest(world, pose(1e-6, 0, 0, tilt, 0)));
    State& state = now.state;
    double two_points = 0;
    for (int n = 0; n < 40000 && two_points == 0; ++n) {
      Pose hand = state.command;
      hand[0] -= 10e-9;
      // Kept centred, so that neither point is pressed before both touch.
      hand[1] = -0.5 * tilt * state.inserted_length();
      step_on(world, hand, 1e-3, now);
      if (state.contact[kEnd].closed && state.contact[kSide].closed)
        two_points = state.inserted_length();
    }
    EXPECT_CLOSE(two_points, 2 * c / tilt, 1e-2) << tilt;
  }
}

// At two points the reaction of a sideways moment M is a couple M/l on end and rim.
TEST(PegInHole, TwoPointForcesCarryTheMoment) {
  const World world = testing::bare({"holder.tilt_stiffness_N_m_rad=1e-6"}).world;
  const double length = 80e-6, tilt = 2 * world.annulus.clearance() / length;
  StepResult r;
  State& state = r.state;
  state.tip = pose(-length, -0.5 * tilt * length, 0, tilt, 0);
  state.command = state.tip;
  state.command[3] = 1.5 * tilt;
  for (int n = 0; n < 20; ++n) step_on(world, Pose(state.command), 1e-3, r);
  ASSERT_TRUE(state.contact[kEnd].closed && state.contact[kSide].closed);
  const double moment = 1e-6 * (state.command[3] - state.tip[3]);
  const TermForces wall = forces(world, r)[Term::wall];
  EXPECT_CLOSE(wall[kEnd].force.y(), moment / state.inserted_length(), 1e-3);
  EXPECT_CLOSE(-wall[kSide].force.y(), moment / state.inserted_length(), 1e-3);
}

// A fibre touching at two points, held by a moment. Friction of Hurtado and Kim on Hertz contacts
// of normal force N is a friction coefficient mu(N), so that Whitney's closed forms apply.
struct TwoPoints {
  World world = testing::bare({R"(laws={"friction":{"form":"corrected","burgers_nm":0.48}})",
                               "holder.tilt_stiffness_N_m_rad=1e-6", testing::kEveryStepSolved})
                    .world;
  StepResult last;
  State& state = last.state;

  TwoPoints(double length, double moment) {
    const double tilt = 2 * world.annulus.clearance() / length;
    state.tip = state.command = pose(-length, -0.5 * tilt * length, 0, tilt, 0);
    hold(tilt + moment / 1e-6, 50);
  }
  // To a tilt of the hand, in small steps.
  void hold(double tilt, int steps) {
    const double from = state.command[3];
    for (int n = 1; n <= steps; ++n) {
      Pose hand = state.command;
      hand[3] = from + (tilt - from) * n / steps;
      move(hand);
    }
  }
  void move(const Pose& hand) {
    step_on(world, hand, 1e-3, last);
    ASSERT_EQ(last.status, StepStatus::ok);
  }
  double moment() const { return 1e-6 * (state.command[3] - state.tip[3]); }
  double coefficient(double normal) const {
    const double a = std::cbrt(normal * world.laws.wall->radius / world.laws.wall->reduced_modulus);
    return friction(*friction_law(world.laws), a) / normal;
  }
};

// Whitney 1982, jamming: under a moment M a peg at two points slides in where M/(r F) < l/(2 r mu),
// F the push along the axis; below that push it is stuck. The tilt adds the axial part of the
// normal force at the mouth.
TEST(PegInHole, JamsUpToThePushThatWhitneySays) {
  for (const double length : {40e-6, 80e-6, 200e-6})
    for (const double moment : {2e-10, 1e-9}) {
      TwoPoints peg(length, moment);
      ASSERT_TRUE(peg.state.contact[kEnd].closed && peg.state.contact[kSide].closed);
      const double normal = peg.moment() / length, mu = peg.coefficient(normal);
      const double slides = normal * (2 * mu + peg.state.tip[3]);
      const double x = peg.state.tip[0], stiffness = peg.world.holder.stiffness(0, 0);
      const auto moved_under = [&](double push) {
        Pose hand = peg.state.command;
        hand[0] = x - push / stiffness;
        for (int n = 0; n < 20; ++n) peg.move(hand);
        return x - peg.state.tip[0];
      };
      EXPECT_LT(moved_under(0.95 * slides), 1e-9) << length << " " << moment;
      EXPECT_GT(moved_under(1.05 * slides), 10e-9) << length << " " << moment;
    }
}

// Whitney 1982, wedging: without any force from the hand two contacts hold each other where their
// friction cones contain the line between them, l/(2 r) <= mu; their forces are along that line.
TEST(PegInHole, WedgesWhereTheFrictionConesMeet) {
  for (const double length : {10e-6, 20e-6, 50e-6, 120e-6})
    for (const double moment : {2e-11, 2e-10, 2e-9}) {
      TwoPoints peg(length, moment);
      for (int n = 0; n < 400; ++n)  // the hand goes where the fibre is, and holds nothing
        peg.move(peg.state.command + 0.2 * (peg.state.tip - peg.state.command));
      const Breakdown f = forces(peg.world, peg.last);
      const double normal = f[Term::wall][kEnd].force.y(), slender = 0.5 * length / 62.5e-6;
      ASSERT_GT(normal, 1e-10) << length << " " << moment;
      EXPECT_LT(f.holder.head<3>().norm(), 1e-6 * normal);
      EXPECT_CLOSE(-f[Term::wall][kSide].force.y(), normal, 2e-2);
      EXPECT_GT(peg.coefficient(normal), slender) << length << " " << moment;
      const double along =
          0.5 * (f[Term::friction][kEnd].force.x() - f[Term::friction][kSide].force.x());
      EXPECT_CLOSE(along, slender * normal, 2e-2) << length << " " << moment;
    }
}

}  // namespace
}  // namespace ferrule
