#include "bench/term_cost.hpp"

#include <algorithm>

#include "bench/measure.hpp"
#include "sim/potential.hpp"

namespace ferrule {
namespace {

// A world that models one of the terms, or with "" none.
World with_only(const Plan& plan, const Scene& scene, const std::string& name) {
  Json document = plan.document;
  document.erase("planned_accuracy");
  for (auto& [law, value] : document["laws"].items()) {
    const bool this_one = law == name;
    value = this_one ? scene.document["laws"][law] : Json();
  }
  document["dynamics"] = name == "inertia" ? "inertial" : "quasi_static";
  World world = parse_scene(document, scene.name).world;
  if (name == "wall")
    world.wall = scene.world.wall;
  else
    world.wall.reset();
  return world;
}

}  // namespace

double term_cost(const Plan& plan, const Scene& scene, const PlannedTerm& term) {
  constexpr int kTurns = 8;  // both are timed in turns, so that neither is the one disturbed
  const World with = with_only(plan, scene, term.name), without = with_only(plan, scene, "");
  const auto time = [&](const World& world) {
    return nanoseconds_per_call(
        [&](long) {
          const Lagged lagged = lag(world, term.state, term.state.hand, plan.step);
          keep(Potential(world, lagged, term.state.tip));
        },
        2e5);
  };
  double most = time(with), least = time(without);
  for (int turn = 1; turn < kTurns; ++turn) {
    most = std::min(most, time(with));
    least = std::min(least, time(without));
  }
  return std::max(0.0, most - least);
}

}  // namespace ferrule
