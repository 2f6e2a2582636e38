// Surface forces of any strength, over the whole inserted length: they may pull the fibre in by
// what a longer overlap gains, and press it to the wall, but they must not press it into the wall
// until it is swallowed.
#include <gtest/gtest.h>

#include "sim/geometry/contact_depth.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// Largest energy per length that the surfaces can gain: down to where the mean planes meet [N].
double deepest(const World& world) {
  const double h = -world.annulus.roughness;
  double w = 0;
  if (const auto* law = std::get_if<VanDerWaals>(&world.laws.van_der_waals))
    w -= van_der_waals(*law, world.annulus, h).potential;
  if (const auto* law = std::get_if<Electrostatic>(&world.laws.electrostatic))
    w -= electrostatic(*law, world.annulus, h).potential;
  return w;
}

TEST(PressedSurfaces, PullTheFibreInByTheEnergyOfTheOverlapAtMost) {
  const struct {
    const char* laws;
    double roughness_nm;
  } cases[] = {
      {R"({"van_der_waals":{"form":"corrected","hamaker_J":3.67e-19}})", 0},
      {R"({"van_der_waals":{"form":"corrected","hamaker_J":3.67e-19}})", 0.5},
      {R"({"electrostatic":{"form":"corrected","voltage_V":1}})", 0},
      {R"({"electrostatic":{"form":"corrected","voltage_V":30}})", 5},
      {R"({"van_der_waals":{"form":"corrected","hamaker_J":1e-18},
           "electrostatic":{"form":"corrected","voltage_V":2}})",
       0.2},
  };
  for (const auto& [laws, roughness] : cases) {
    Json d = testing::paper().document();
    d["laws"] = Json::parse(laws);
    d["roughness_nm"] = roughness;
    const Scene scene = parse_scene(d, "test");
    const double stiffness = scene.world.holder.stiffness(0, 0);
    for (std::uint64_t trial = 1; trial <= 1; ++trial) {
      State state = draw_start(scene, 1, trial);
      const double reach = deepest(scene.world) / stiffness;
      for (int n = 0; n < 400; ++n) {
        Pose hand = state.command;
        if (n < 300) hand[0] -= 200e-9;  // 60 um
        hand[1] += 1e-8 * std::sin(0.03 * n);
        const StepResult r = step(scene.world, state, hand, 1e-3);
        state = r.state;
        ASSERT_TRUE(state.tip.allFinite());
        // Not further ahead of the hand than the pull can stretch the holder; twice that where it
        // is on its way, as the energy of the overlap allows.
        const double most = r.status == StepStatus::ok ? 1.01 : 2.02;
        ASSERT_GE(state.tip[0], hand[0] - most * reach - 1e-8) << laws << " step " << n;
        const auto depths = contact_depths(
            scene.world, contact_side(scene.world, state.tip, state.side), state.tip);
        for (const ContactDepth& depth : depths) ASSERT_LT(depth.value, 50e-9) << laws;
      }
    }
  }
}

}  // namespace
}  // namespace ferrule
