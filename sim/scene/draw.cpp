#include "sim/scene/draw.hpp"

#include "sim/scene/random.hpp"

namespace ferrule {

std::shared_ptr<const Scene> draw_scene(const Scene& scene, std::uint64_t seed,
                                        std::uint64_t trial) {
  if (!scene.tolerance) return {std::shared_ptr<const Scene>(), &scene};
  RandomStream random(seed, trial, Draw::parts);
  const Tolerance& t = *scene.tolerance;
  double deviation = random.normal();
  while (std::abs(deviation) > 3) deviation = random.normal();
  const double fibre = 2 * scene.world.annulus.fibre_radius + t.fibre_sd * deviation;
  const double bore = t.bore_low + (t.bore_high - t.bore_low) * random.uniform();
  if (fibre >= bore) return nullptr;
  const auto drawn = std::make_shared<Scene>(scene);
  drawn->tolerance.reset();
  WorldParameters& p = drawn->parameters;
  p.fibre.diameter_um = 1e6 * fibre;
  p.ferrule.bore_diameter_um = 1e6 * bore;
  if (const auto found = inconsistency(p))
    throw BadInput(scene.name + ": tolerance: " + found->key + " " + found->rule);
  drawn->world = make_world(p);
  // What a recording states of its scene.
  Json& document = drawn->document;
  document["drawn_from"] = {{"tolerance", document["tolerance"]},
                            {"fibre_diameter_um", document["fibre"]["diameter_um"]},
                            {"ferrule_bore_diameter_um", document["ferrule"]["bore_diameter_um"]}};
  document.erase("tolerance");
  document["fibre"]["diameter_um"] = p.fibre.diameter_um;
  document["ferrule"]["bore_diameter_um"] = p.ferrule.bore_diameter_um;
  return drawn;
}

FeasibleTrial feasible_trial(const Scene& scene, std::uint64_t seed, std::uint64_t trial) {
  constexpr std::size_t kMost = 10000;
  FeasibleTrial found{nullptr, trial, 0};
  while (!(found.scene = draw_scene(scene, seed, found.trial))) {
    if (++found.infeasible == kMost)
      throw BadInput(scene.name + ": tolerance: of " + std::to_string(kMost) +
                     " drawn pairs of parts not one fits");
    found.trial += std::uint64_t{1} << 32;
  }
  return found;
}

Json undrawn(Json document) {
  if (!document.contains("drawn_from")) return document;
  const Json from = document["drawn_from"];
  document.erase("drawn_from");
  document["tolerance"] = from["tolerance"];
  document["fibre"]["diameter_um"] = from["fibre_diameter_um"];
  document["ferrule"]["bore_diameter_um"] = from["ferrule_bore_diameter_um"];
  return document;
}

State draw_start(const Scene& scene, std::uint64_t seed, std::uint64_t trial) noexcept {
  RandomStream random(seed, trial, Draw::start);
  Pose tip;
  tip[0] = scene.start.distance;
  tip[1] = scene.start.lateral_mean.x() + scene.start.lateral_sd * random.normal();
  tip[2] = scene.start.lateral_mean.y() + scene.start.lateral_sd * random.normal();
  tip[3] = scene.start.tilt_sd * random.normal();
  tip[4] = scene.start.tilt_sd * random.normal();
  return at_rest(scene.world, tip);
}

}  // namespace ferrule
