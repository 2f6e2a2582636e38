#include "sim/terms/potential.hpp"

#include "sim/base/random.hpp"
#include "sim/solver/newton.hpp"
#include "sim/solver/step.hpp"
#include "sim/terms/contact.hpp"
#include "tests/compare.hpp"
#include "tests/energy_derivatives.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// A pose somewhere around the mouth of the bore, in or near contact.
Pose random_pose(RandomStream& random, const World& world) {
  const double c = world.annulus.clearance();
  const auto around = [&](double scale) { return scale * (2 * random.uniform() - 1); };
  Pose tip;
  tip << around(30e-6), around(1.05 * c), around(0.3 * c), around(1e-3), around(1e-3);
  return tip;
}

struct Case {
  FrozenCoefficients frozen;
  Pose tip;
};

// Poses where every term acts somewhere: random ones, each with the history of a short motion.
// Every fourth has its end so near the mouth that it cuts the side's contact.
std::vector<Case> cases(const World& world, std::uint64_t seed) {
  std::vector<Case> all;
  for (std::uint64_t k = 0; k < 60; ++k) {
    RandomStream random(seed, k, Draw::start);
    Pose tip = random_pose(random, world);
    if (k % 4 == 0) {
      tip[0] = -(0.1 + 0.8 * random.uniform()) * kPatch;
      tip.segment<2>(1) = 1.002 * world.annulus.clearance() * tip.segment<2>(1).normalized();
    }
    StepResult now(at_rest(world, tip));
    State& state = now.state;
    Pose hand = state.command;
    for (int n = 0; n < 3; ++n) {
      hand[0] -= 5e-9;
      hand[1] -= 1e-8;
      step_on(world, hand, 1e-3, now);
    }
    FrozenCoefficients frozen = freeze(world, state, hand, 1e-3);
    // A slipping contact is at the knee of Huber's potential: past it, where it has derivatives.
    for (FrozenFriction& friction : frozen.friction)
      if (friction.acts) friction.limit *= 0.5;
    all.push_back({frozen, state.tip});
  }
  return all;
}

double length_of(int i) {
  return i < 3 ? 1 : 1e-4;
}  // 1 m of position counts as 1e4 rad of tilt

TEST(Potential, GradientIsTheDerivativeOfTheValue) {
  const World world = testing::paper().world;
  int compared = 0;
  for (const Case& c : cases(world, 3)) {
    const Potential here(world, c.frozen, c.tip);
    const Pose gradient = here.gradient.full();
    for (int i = 0; i < 5; ++i) {
      const double h = 2e-12 / length_of(i);
      const auto slope_by = [&](double step) {
        return testing::derivative(
            [&](double d) {
              Pose tip = c.tip;
              tip[i] += d;
              return Potential(world, c.frozen, tip).value;
            },
            0, step);
      };
      const double slope = slope_by(h);
      // What rounding of the energy, and turning of a slipping contact's friction, leave of a
      // difference.
      const double noise =
          30 * 2.2e-16 * here.value_scale / h + std::abs(slope - slope_by(0.5 * h));
      const double scale =
          std::max(std::abs(gradient[i]), here.force_scale * 1e-4 / length_of(i) * 1e-4);
      if (noise > 1e-3 * scale) continue;
      ++compared;
      EXPECT_LT(std::abs(slope - gradient[i]), 1e-4 * scale + noise) << i;
    }
  }
  EXPECT_GT(compared, 100);
}

TEST(Potential, HessianIsTheDerivativeOfTheGradient) {
  const World world = testing::paper().world;
  for (const Case& c : cases(world, 4)) {
    const Potential here(world, c.frozen, c.tip);
    const Matrix5 hessian = here.hessian.full();
    // The laws' slope jumps at the ends of their printed range.
    const double gap =
        world.annulus.clearance() - eccentricity(c.tip, 0.5 * c.frozen.length).norm();
    if (c.frozen.length > 0 && gap > 0 && gap < 0.12e-9) continue;
    for (int i = 0; i < 5; ++i)
      for (int j = 0; j < 5; ++j) {
        const double slope = testing::derivative(
            [&](double d) {
              Pose tip = c.tip;
              tip[i] += d;
              return Potential(world, c.frozen, tip).gradient.full()[j];
            },
            0, 1e-13 / length_of(i));
        const double scale =
            std::sqrt(hessian.diagonal().cwiseAbs()[i] * hessian.diagonal().cwiseAbs()[j]);
        EXPECT_LT(std::abs(slope - hessian(j, i)), 2e-3 * scale) << i << " " << j;
      }
  }
}

TEST(Potential, GradientIsMinusTheWrenchOfTheBreakdown) {
  const World world = testing::paper().world;
  int cut = 0;
  for (const Case& c : cases(world, 5)) {
    const Potential here(world, c.frozen, c.tip);
    cut += here.push_out + here.pull_out != 0;
    Breakdown b;
    forces(world, c.frozen, c.tip, here, b);
    const Wrench left = b.sum(c.tip) - b.holder + here.gradient.full();
    EXPECT_LT(left.head<3>().norm(), 1e-9 * here.force_scale);
    // Moments to first order in the tilts: arms of the radius times a tilt are left out.
    EXPECT_LT(left.tail<2>().norm(), 1e-2 * 62.5e-6 * here.force_scale);
  }
  EXPECT_GT(cut, 5);
}

// The side's contact plane is inclined by the tilt: friction is perpendicular to that normal.
TEST(Potential, FrictionOfATiltedSideIsTheSlopeOfItsEnergy) {
  const World world =
      testing::bare({"laws.friction={\"form\":\"corrected\",\"burgers_nm\":0.48}"}).world;
  const double tilt = 0.25, length = 20e-6, c = world.annulus.clearance();
  State state;
  state.tip << -length, c - tilt * length + 3e-9, 0, tilt, 0;
  state.command = state.tip;
  state.contact[kSide].closed = true;
  state.contact[kSide].stuck = Vector3d(-length, c + 3e-9, 0);
  const FrozenCoefficients frozen = freeze(world, state, state.command, 1e-3);
  ASSERT_TRUE(frozen.friction[kSide].acts);
  for (const double slid : {1e-11, 3e-9}) {  // stuck, slipping
    Pose tip = state.tip;
    tip[0] += slid;
    tip[2] += 0.5 * slid;
    const Potential here(world, frozen, tip);
    for (int i = 0; i < 3; ++i) {
      const double slope = testing::derivative(
          [&](double d) {
            Pose moved = tip;
            moved[i] += d;
            return Potential(world, frozen, moved).value;
          },
          0, 1e-13);
      EXPECT_NEAR(slope, here.gradient.full()[i], 1e-4 * here.force_scale) << slid << " " << i;
    }
  }
}

TEST(Potential, OfTwoContactsSharesTheAdhesionOfOne) {
  const World world = testing::paper({"laws.van_der_waals=null", "laws.electrostatic=null",
                                      "laws.capillary=null", "start.tilt_sd_mrad=0"})
                          .world;
  Pose tip;
  tip << -20e-6, -world.annulus.clearance() - 10.01e-9, 0, 0, 0;
  StepResult now;
  State& state = now.state;
  state.tip = state.command = tip;
  for (int n = 0; n < 4; ++n) step_on(world, tip, 1e-3, now);
  const Breakdown b = forces(world, now);
  EXPECT_TRUE(state.contact[kEnd].closed);
  EXPECT_TRUE(state.contact[kSide].closed);
  EXPECT_CLOSE(b[Term::adhesion][kEnd].force.y() + b[Term::adhesion][kSide].force.y(),
               -7.830277437e-6, 1e-6);
}

// Where the end has just come in, and a wall that pushes all along would make an edge.
TEST(Potential, OfSurfaceForcesBeginsSmoothlyAtTheMouth) {
  for (const char* sums : {"tilted_axes=\"closed_form\"", "tilted_axes=\"quadrature\""}) {
    const World world =
        testing::bare({"laws.van_der_waals={\"form\":\"corrected\",\"hamaker_J\":6e-19}",
                       "laws.electrostatic={\"form\":\"corrected\",\"voltage_V\":1}", sums})
            .world;
    for (const double out : {0.5, 0.999}) {
      const auto inwards = [&](double x) {
        const Pose tip = testing::pose(x, out * world.annulus.clearance(), 0);
        return Potential(world, freeze(world, at_rest(world, tip), tip, 0), tip).bore.gradient.x;
      };
      EXPECT_LT(std::abs(inwards(-0.1e-9)), 1e-2 * std::abs(inwards(-20e-9)));
      for (double x = -0.5e-9; x > -12e-9; x -= 0.47e-9) {
        const Pose tip = testing::pose(x, out * world.annulus.clearance(), 0, 1e-4, 2e-5);
        const FrozenCoefficients frozen = freeze(world, at_rest(world, tip), tip, 1e-3);
        SCOPED_TRACE(x);
        testing::expect_energy_derivatives(world, frozen, tip, 1e-6,
                                           {2e-12, 1e-12, 1e-12, 1e-8, 1e-8});
      }
    }
  }
}

TEST(Potential, OfSurfaceForcesEndsSmoothlyAtTheEndOfTheBore) {
  const World world =
      testing::bare({"laws.van_der_waals={\"form\":\"corrected\",\"hamaker_J\":6e-19}",
                     "laws.electrostatic={\"form\":\"corrected\",\"voltage_V\":1}",
                     "ferrule.length_mm=0.3"})
          .world;
  const double length = world.profile.length, out = 0.999 * world.annulus.clearance();
  const auto inwards = [&](double left) {
    const Pose tip = testing::pose(left - length, out, 0);
    return Potential(world, freeze(world, at_rest(world, tip), tip, 0), tip).bore.gradient.x;
  };
  EXPECT_GT(inwards(11e-9), 0);  // its energy falls as it goes in
  EXPECT_CLOSE(inwards(10.001e-9), inwards(11e-9), 1e-3);
  EXPECT_LT(std::abs(inwards(0.1e-9)), 1e-2 * inwards(11e-9));
  EXPECT_EQ(inwards(-1e-9), 0);
  for (double left = -0.7e-9; left < 12e-9; left += 0.47e-9) {
    const Pose tip = testing::pose(left - length, out, 0, 1e-5, 2e-6);
    const FrozenCoefficients frozen = freeze(world, at_rest(world, tip), tip, 1e-3);
    SCOPED_TRACE(left);
    testing::expect_energy_derivatives(world, frozen, tip, 1e-6, {2e-12, 1e-12, 1e-12, 1e-9, 1e-9});
  }
}

// Along a fibre that lies on the wall and is tilted ever more: the energy is that of its gradient.
TEST(Potential, OfAFibreAlongTheWallIsContinuous) {
  const World world =
      testing::bare({"laws.electrostatic={\"form\":\"corrected\",\"voltage_V\":1}"}).world;
  const double length = 700e-6, c = world.annulus.clearance();
  const auto at = [&](double tilt) {
    const Pose tip = testing::pose(-length, c, 0.5 * tilt * length, 0, -tilt);
    return Potential(world, freeze(world, at_rest(world, tip), tip, 1e-3), tip).bore;
  };
  const double step = 5e-8;
  Energy before = at(0);
  for (int n = 1; n <= 400; ++n) {
    const Energy now = at(n * step);
    const PoseVector move = Pose(testing::pose(0, 0, 0.5 * step * length, 0, -step));
    const double by_gradient = 0.5 * (before.gradient.dot(move) + now.gradient.dot(move));
    EXPECT_LE(std::abs(now.value - before.value - by_gradient), 1e-7 * std::abs(now.value)) << n;
    before = now;
  }
}

// The side that moves along the wall turns about the axis; what is free only follows.
TEST(Potential, AMoveAlongTheWallDoesNotTiltTheFibre) {
  const World world = testing::bare().world;
  const double c = world.annulus.clearance(), length = 100e-6;
  const PoseVector sideways{0, Vector2d(0, 0.2 * c), Vector2d::Zero()};
  for (const bool end : {true, false}) {
    const Pose tip = end ? testing::pose(-length, c, 0, -0.3 * c / length, 0)
                         : testing::pose(-length, 0.7 * c, 0, 0.3 * c / length, 0);
    const FrozenCoefficients frozen = freeze(world, at_rest(world, tip), tip, 1e-3);
    const PoseVector there = retract(world, frozen, tip, sideways);
    EXPECT_EQ(there.t, PoseVector(tip).t);
    const Vector2d touches = end ? there.e : Vector2d(there.e + length * there.t);
    EXPECT_CLOSE(touches.norm(), c, 1e-12);
    EXPECT_NEAR(touches.y() / (0.2 * c), 1, 0.02);
  }
}

}  // namespace
}  // namespace ferrule
