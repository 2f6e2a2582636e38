#include "sim/analysis/release.hpp"

#include <cmath>
#include <numbers>

#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;
using testing::kFibreRadius;

constexpr double w = 0.02, kLength = 100e-6;

Scene with(const std::vector<std::string>& more) {
  std::vector<std::string> settings = {"laws={}"};
  settings.insert(settings.end(), more.begin(), more.end());
  return load_scene("bench", settings);
}
std::string adhesion(double lambda) {
  return "laws.adhesion={\"form\":\"corrected\",\"work_of_adhesion_J_m2\":0.02,\"maugis_lambda\":" +
         std::to_string(lambda) + "}";
}
double term(const Release& r, Term t) {
  return r.terms[static_cast<std::size_t>(t)];
}

TEST(Release, LiftIsThePullOffForceOfEveryPlace) {
  for (const auto& [lambda, P, within] : {std::tuple{100.0, 1.5, 0.01}, {0.01, 2.0, 0.02}})
    for (const int places : {1, 2}) {
      const Scene scene = with({adhesion(lambda)});
      const auto rows = release(scene.world, kLength, places, 0);
      EXPECT_CLOSE(rows[0].force, places * P * pi * w * kFibreRadius, within);
      EXPECT_CLOSE(rows[1].force, P * pi * w * kFibreRadius,
                   within);  // one after the other
    }
}

// An elastic fibre's gripper carries the other half.
TEST(Release, OfNothingButWeightIsTheWeightThatTheEndCarries) {
  const Scene scene = with({"laws.gravity={\"form\":\"corrected\"}"});
  const auto rows = release(scene.world, kLength, 2, 0);
  const double expected = 0.5 * 2200 * pi * kFibreRadius * kFibreRadius * 0.01 * 9.80665;
  EXPECT_CLOSE(rows[0].force, expected, 1e-9);
  EXPECT_CLOSE(rows[1].force, expected, 1e-9);
  EXPECT_EQ(rows[2].force, 0);  // no friction law
  EXPECT_EQ(release(with({}).world, kLength, 2, 0)[0].force, 0);
}

// Annulus, closed form (1c), where the rough mean planes touch: the largest pull.
TEST(Release, OfVanDerWaalsIsThatAtTheRoughness) {
  const Scene scene = with(
      {"laws.van_der_waals={\"form\":\"corrected\",\"hamaker_J\":1.1e-19}", "roughness_nm=10"});
  const double c = 510e-9, e = 500e-9;
  const double f = 1.1e-19 * kFibreRadius * c * e / (2 * std::pow(c * c - e * e, 2.5)) * kLength;
  const auto rows = release(scene.world, kLength, 2, 0);
  EXPECT_CLOSE(rows[0].force, f, 1e-6);
  EXPECT_CLOSE(rows[1].force, 0.5 * f, 1e-4);  // about the end, before it turns
}

// Slope of a wall that is pressed with a load: Hertz, a^3 = F R/K.
TEST(Release, FrictionIsThatOfTheLoadedContact) {
  const Scene scene = with({"laws.gravity={\"form\":\"corrected\"}",
                            "laws.friction={\"form\":\"corrected\",\"burgers_nm\":0.2}",
                            "laws.meniscus={\"form\":\"corrected\",\"surface_tension_N_m\":0.072,"
                            "\"contact_angle_deg\":60}",
                            "laws.drag={\"form\":\"corrected\",\"viscosity_Pa_s\":0.1}"});
  const World& world = scene.world;
  const double load = 0.5 * 2200 * pi * kFibreRadius * kFibreRadius * 0.01 * 9.80665;
  const double K = reduced_modulus(72e9, 0.17, 210e9, 0.3);
  EXPECT_CLOSE(loaded_radius(world, load), std::cbrt(load * kFibreRadius / K), 1e-9);
  const auto one = release(world, kLength, 1, 0)[2], moving = release(world, kLength, 1, 1e-5)[2];
  EXPECT_CLOSE(term(one, Term::friction),
               friction(*friction_law(world.laws), std::cbrt(load * kFibreRadius / K)), 1e-9);
  EXPECT_CLOSE(term(one, Term::meniscus), 2 * pi * kFibreRadius * 0.072 * std::cos(pi / 3), 1e-9);
  EXPECT_EQ(term(one, Term::drag), 0);
  EXPECT_GT(term(moving, Term::drag), 0);
  EXPECT_CLOSE(moving.force, one.force + term(moving, Term::drag), 1e-12);
}

// Without load JKR's contact has a^3 = 6 pi w R^2/K.
TEST(Release, AnUnloadedContactHasTheRadiusOfJkr) {
  const Scene scene = with({adhesion(100)});
  const double K = reduced_modulus(72e9, 0.17, 210e9, 0.3);
  EXPECT_CLOSE(loaded_radius(scene.world, 0),
               std::cbrt(6 * pi * w * kFibreRadius * kFibreRadius / K), 0.01);
}

// A stiff-in-tilt hand that lifts the fibre off the wall in the simulator needs that force.
TEST(Release, IsWhatTheSimulatorTakes) {
  const Scene scene =
      with({adhesion(1), "laws.van_der_waals={\"form\":\"corrected\",\"hamaker_J\":1.1e-19}",
            "holder={\"type\":\"rigid_hand\",\"stiffness_N_m\":2,\"tilt_stiffness_N_m_rad\":1}"});
  const World& world = scene.world;
  const double c = world.annulus.clearance();
  StepResult r(at_rest(world, testing::pose(-kLength, 0, 0)));
  const State& state = r.state;
  double most = 0;
  const auto go = [&](double from, double to) {
    const int steps = 40000;
    for (int n = 1; n <= steps; ++n) {
      step_on(world, testing::pose(-kLength, from + (to - from) * n / steps, 0), 1e-3, r);
      if (state.tip[1] < 0) most = std::max(most, -r.holder[1]);  // then the other wall
    }
  };
  go(0, -1.02 * c);
  ASSERT_TRUE(state.contact[kEnd].closed && state.contact[kSide].closed);
  most = 0;
  go(-1.02 * c, 30 * c);
  EXPECT_GT(state.tip[1], 0);
  EXPECT_CLOSE(most, release(world, kLength, 2, 0)[0].force, 0.02);
}

}  // namespace
}  // namespace ferrule
