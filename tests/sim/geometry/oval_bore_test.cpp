#include "sim/geometry/oval_bore.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"
#include "sim/terms/potential.hpp"
#include "tests/closed_motion.hpp"
#include "tests/compare.hpp"
#include "tests/energy_derivatives.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;

std::vector<std::string> oval(double um, double degrees) {
  return {"ferrule.ovality_um=" + std::to_string(um),
          "ferrule.ovality_direction_deg=" + std::to_string(degrees)};
}

// How deep the rim of an upright end is in the wall r + ... by its points.
double deepest(const World& world, const Vector2d& e, double ovality, double direction) {
  double most = -INFINITY;
  for (int i = 0; i < 20000; ++i) {
    const double angle = 2 * pi * i / 20000;
    const Vector2d u(std::cos(angle), std::sin(angle));
    most = std::max(most, u.dot(e) - 0.25 * ovality * std::cos(2 * (angle - direction)));
  }
  return most - world.annulus.clearance();
}

TEST(OvalBore, AContactIsAsDeepAsTheDeepestPointOfTheRimToFirstOrder) {
  double worst = 0;
  for (const double um : {0.2, 0.1, 0.05}) {
    double now = 0;
    for (int k = 0; k < 24; ++k) {
      const double direction = 0.6, angle = k * pi / 12;
      const World world = testing::bare(oval(um, direction * 180 / pi)).world;
      State state;
      const Vector2d e = 0.5e-6 * Vector2d(std::cos(angle), std::sin(angle));
      state.tip << -20e-6, e, 0, 0;
      const double depth =
          contact_depths(world, contact_side(world, state.tip, state.side), state.tip)[kEnd].value;
      now = std::max(now, std::abs(depth - deepest(world, e, 1e-6 * um, direction)));
    }
    EXPECT_LT(now, 0.06e-6 * um);  // of the 0.25 um/um that it is
    if (worst > 0) {
      EXPECT_LT(now, 0.6 * worst);
    }
    worst = now;
  }
}

TEST(OvalBore, AFibreHasRoomInTheWideDirection) {
  const Scene scene = testing::bare(oval(0.2, 90));
  const auto rests = [&](const Vector2d& towards) {
    StepResult now(at_rest(scene.world, testing::pose(-50e-6, 0, 0)));
    State& state = now.state;
    Pose hand = state.command;
    for (int n = 0; n < 700; ++n) {
      hand.segment<2>(1) += 1e-9 * towards;
      step_on(scene.world, hand, 1e-3, now);
    }
    return state.tip.segment<2>(1).dot(towards) - state.contact[kEnd].depth;
  };
  EXPECT_CLOSE(rests(Vector2d(0, 1)), 0.55e-6, 2e-3);
  EXPECT_CLOSE(rests(Vector2d(1, 0)), 0.45e-6, 2e-3);
}

TEST(OvalBore, ARoundOneIsAsItWas) {
  const Scene round = load_scene("bench"), zero = load_scene("bench", oval(0, 30));
  const State start = at_rest(round.world, testing::pose(-30e-6, 4e-7, 1e-7, 1e-3, 0));
  EXPECT_EQ(to_row(step(round.world, start, start.command, 1e-3).state),
            to_row(step(zero.world, start, start.command, 1e-3).state));
}

// Along the axes of the ellipse the stretched gap is that to the wall times c/(c +- q).
TEST(OvalBore, TheLawsOfTheAnnulusKnowTheGap) {
  const double q = 0.05e-6, c = 0.5e-6;
  const OvalBore bore(4 * q, c, Vector2d::UnitY());
  for (const double h : {1e-9, 50e-9}) {
    const PoseVector wide(0, Vector2d(0, c + q - h), Vector2d::Zero());
    EXPECT_CLOSE(c - bore.stretched(wide).e.norm(), h * c / (c + q), 1e-9);
    const PoseVector narrow(0, Vector2d(c - q - h, 0), Vector2d::Zero());
    EXPECT_CLOSE(c - bore.stretched(narrow).e.norm(), h * c / (c - q), 1e-9);
  }
}

TEST(OvalBore, GradientAndHessianOfTheEnergyAreItsDerivatives) {
  for (const char* name : {"bench", "sticky", "epoxy", "paper"}) {
    std::vector<std::string> settings = oval(0.15, 25);
    settings.emplace_back("laws.friction=null");
    const World world = load_scene(name, settings).world;
    for (const double y : {0.2e-6, 0.44e-6}) {
      State state = at_rest(world, testing::pose(-40e-6, y, 0.1e-6, 1e-3, -5e-4));
      const FrozenCoefficients frozen = freeze(world, state, state.command, 1e-3);
      SCOPED_TRACE(name + (" at " + std::to_string(y)));
      testing::expect_energy_derivatives(world, frozen, state.tip, 40e-6,
                                         {1e-10, 1e-11, 1e-11, 1e-7, 1e-7});
    }
  }
}

// Where a rounded end lies on the edge between bore and cone its deepest angle turns with the pose.
TEST(OvalBore, SoTheyAreOnTheEdgeOfTheCone) {
  std::vector<std::string> settings = oval(0.3, 60);
  for (const char* more :
       {"fibre.edge_um=0.2", "laws.friction=null", "ferrule.lead_in.angle_deg=50"})
    settings.emplace_back(more);
  const World world = load_scene("bench", settings).world;
  int on_edge = 0;
  for (const double x : {-0.19e-6, -0.17e-6, -0.15e-6, -0.13e-6}) {
    const State state = at_rest(world, testing::pose(x, 0.56e-6, 0.13e-6, -1e-3, 6e-3));
    const FrozenCoefficients frozen = freeze(world, state, state.command, 1e-3);
    const ContactDepth depth = contact_depths(world, frozen.contact, state.tip)[kEnd];
    on_edge += depth.edge > 0 && depth.value > 0;
    SCOPED_TRACE(x);
    testing::expect_energy_derivatives(world, frozen, state.tip, 60e-6,
                                       {1e-11, 1e-11, 1e-11, 1e-7, 1e-7});
  }
  EXPECT_GE(on_edge, 2);
}

TEST(OvalBore, NoClosedMotionGainsEnergy) {
  for (std::uint64_t k = 0; k < 20; ++k) {
    RandomStream random(14, k, Draw::start);
    std::vector<std::string> settings = oval(0.3 * random.uniform(), 180 * random.uniform());
    if (k % 2) settings.emplace_back("fibre.edge_um=2");
    const Scene scene = load_scene(k % 3 ? "bench" : "sticky", settings);
    SCOPED_TRACE(k);
    testing::expect_no_energy_gained(scene.world, testing::pose(0.5e-6, 0, 0),
                                     {100, 260, 300, 2e-7, 0.2e-6, 1e-4}, random);
  }
}

TEST(OvalBore, LiesInADirectionThatChanceDecides) {
  const Scene scene = testing::bare({"ferrule.ovality_um=0.2"});
  const auto a = draw_scene(scene, 1, 1), b = draw_scene(scene, 1, 2);
  EXPECT_NE(a->world.oval.widest, b->world.oval.widest);
  EXPECT_EQ(undrawn(a->document()), scene.document());
  EXPECT_EQ(parse_scene(a->document(), "drawn").world.oval.widest, a->world.oval.widest);
  EXPECT_THROW(testing::bare({"ferrule.ovality_um=0.7"}), BadInput);
}

}  // namespace
}  // namespace ferrule
