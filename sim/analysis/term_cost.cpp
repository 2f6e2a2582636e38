#include "sim/analysis/term_cost.hpp"

#include <algorithm>

#include "sim/base/measure.hpp"
#include "sim/scene/terms.hpp"
#include "sim/terms/potential.hpp"

namespace ferrule {
namespace {

// The planned scene with one of the scene's terms alone, or with none for "".
World with_only(const Scene& planned, const Scene& scene, const std::string& name) {
  WorldParameters parameters = planned.parameters;
  parameters.laws = scene.parameters.laws;
  for (const Term term : kAllTerms)
    if (info(term).name != name) info(term).leave_out(parameters.laws);
  parameters.dynamics = name == "inertia" ? Dynamics::inertial : Dynamics::quasi_static;
  World world = make_world(parameters);
  world.laws.wall = name == "wall" ? scene.world.laws.wall : std::nullopt;
  return world;
}

}  // namespace

double term_cost(const Plan& plan, const Scene& scene, const PlannedTerm& term) {
  constexpr int kRounds = 8;  // both are timed in turns, so that neither is the one disturbed
  const Scene planned = parse_scene(plan.document, scene.name);
  const World with = with_only(planned, scene, term.name), without = with_only(planned, scene, "");
  const auto time = [&](const World& world) {
    return nanoseconds_per_call(
        [&](long) {
          const FrozenCoefficients frozen =
              freeze(world, term.state, term.state.command, plan.step);
          keep(Potential(world, frozen, term.state.tip));
        },
        2e5);
  };
  double most = time(with), least = time(without);
  for (int turn = 1; turn < kRounds; ++turn) {
    most = std::min(most, time(with));
    least = std::min(least, time(without));
  }
  return std::max(0.0, most - least);
}

}  // namespace ferrule
