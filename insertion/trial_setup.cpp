#include "insertion/trial_setup.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

TrialSetup of_drawn(std::shared_ptr<const Scene> scene, std::uint64_t seed, std::uint64_t trial,
                    const std::string& redrawn) {
  const Scene& s = *scene;
  return {std::move(scene),
          draw_start(s, seed, trial),
          ForceSensor(s.sensor, seed_of("sensor", redrawn, seed), trial),
          scene_scaling(s),
          seed,
          trial};
}

}  // namespace

std::optional<TrialSetup> trial_setup(const Scene& scene, std::uint64_t seed, std::uint64_t trial,
                                      const std::string& redrawn) {
  std::shared_ptr<const Scene> drawn = draw_scene(scene, seed, trial, redrawn);
  if (!drawn) return std::nullopt;
  return of_drawn(std::move(drawn), seed, trial, redrawn);
}

TrialSetup feasible_setup(const Scene& scene, std::uint64_t seed, std::uint64_t trial) {
  const FeasibleTrial drawn = feasible_trial(scene, seed, trial);
  TrialSetup setup = of_drawn(drawn.scene, seed, drawn.trial, "");
  setup.infeasible = drawn.infeasible;
  return setup;
}

}  // namespace ferrule
