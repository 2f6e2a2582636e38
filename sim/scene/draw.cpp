#include "sim/scene/draw.hpp"

#include <algorithm>
#include <numbers>

#include "sim/base/elementary.hpp"
#include "sim/base/random.hpp"
#include "sim/base/units.hpp"
#include "sim/geometry/curl.hpp"
#include "sim/scene/read_scene.hpp"
#include "sim/scene/scene_keys.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

// The highest of the particles on the wall of the length that goes in.
void draw_particle(Scene& drawn, RandomStream random) {
  WorldParameters& p = drawn.parameters;
  Particle& law = *p.laws.particle;
  double height = 0;
  // As many as exponential waiting times fit into their mean number.
  for (double waited = 0; (waited -= elementary::log(random.uniform())) < law.number;)
    height = std::max(height, law.median * elementary::exp(law.spread * random.normal()));
  const double height_um = 1e6 * std::min(height, kHighestParticle);
  law.height = micro * height_um;
  const double least = (1 + 1e-12) * shallowest(p, law.height);  // in micrometres too
  const double most = std::max(least, drawn.success.depth);
  const double at_um = 1e6 * (least + (most - least) * random.uniform());
  law.depth = micro * at_um;
  const double degrees = 360 * random.uniform();
  law.direction = degree * degrees;
  drawn.decided.push_back({"laws.particle.height_um", height_um});
  drawn.decided.push_back({"laws.particle.at_um", at_um});
  drawn.decided.push_back({"laws.particle.direction_deg", degrees});
}

}  // namespace

std::shared_ptr<const Scene> draw_scene(const Scene& scene, std::uint64_t seed, std::uint64_t trial,
                                        const std::string& redrawn) {
  const std::optional<Particle>& law = scene.parameters.laws.particle;
  const bool particle = law && std::isnan(law->height);
  if (scene.drawn.empty() && !particle) return {std::shared_ptr<const Scene>(), &scene};
  auto drawn = std::make_shared<Scene>(scene);
  drawn->drawn.clear();
  const auto decide = [&](const DrawnNumber& number) {
    const double value = number.draw(seed, trial, redrawn);
    drawn->decided.push_back({number.key, value});
    return set_number(*drawn, number.key, value);
  };
  // What the scene states comes first, as the rest follows of it.
  for (const DrawnNumber& number : scene.drawn)
    if (!number.implied && !decide(number)) return nullptr;
  for (const DrawnNumber& number : unstated_numbers(*drawn))
    if (!decide(number)) return nullptr;
  if (resolve(*drawn)) return nullptr;  // each of the numbers can be, but not these together
  if (particle) {
    draw_particle(*drawn, {seed_of("laws.particle", redrawn, seed), trial, Draw::particle});
    drawn->world.laws.particle = ferrule::particle(drawn->parameters);
  }
  return drawn;
}

FeasibleTrial feasible_trial(const Scene& scene, std::uint64_t seed, std::uint64_t trial) {
  constexpr std::size_t kMostDraws = 10000;
  FeasibleTrial found{nullptr, trial, 0};
  while (!(found.scene = draw_scene(scene, seed, found.trial))) {
    if (++found.infeasible == kMostDraws)
      throw BadInput(scene.name + ": of " + std::to_string(kMostDraws) +
                     " draws not one has parts that fit");
    found.trial += std::uint64_t{1} << 32;
  }
  return found;
}

State start_at(const World& world, const Pose& tip) noexcept {
  State start = at_rest(world, tip);
  if (world.dynamics == Dynamics::quasi_static) return start;
  World still = world;
  still.dynamics = Dynamics::quasi_static;
  State leaned = step(still, start, start.command, 0).state;
  if (!leaned.contact[kEnd].closed && !leaned.contact[kSide].closed) return start;
  return leaned;
}

State draw_start(const Scene& scene, std::uint64_t seed, std::uint64_t trial) {
  if (!scene.drawn.empty())
    if (const auto drawn = draw_scene(scene, seed, trial)) return draw_start(*drawn, seed, trial);
  Pose tip;
  tip << scene.start.distance, scene.start.lateral + scene.hand.grasp,
      scene.start.tilt + scene.hand.grasp_tilt;
  if (const auto& radius = scene.parameters.fibre.curl_radius_m) {
    const double roll = degree * scene.parameters.fibre.roll_deg.value_or(0);
    tip += curl(*radius, free_length(scene.parameters),
                {elementary::cos(roll), elementary::sin(roll)});
  }
  return start_at(scene.world, tip);
}

}  // namespace ferrule
