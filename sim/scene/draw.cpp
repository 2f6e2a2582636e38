#include "sim/scene/draw.hpp"

#include <algorithm>
#include <numbers>

#include "sim/base/elementary.hpp"
#include "sim/base/random.hpp"
#include "sim/base/units.hpp"
#include "sim/geometry/curl.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

double within(const DiameterRange& range, RandomStream& random) {
  return range.low + (range.high - range.low) * random.uniform();
}

// Cut at 3.
double cut_normal(RandomStream& random) {
  double deviation = random.normal();
  while (std::abs(deviation) > 3) deviation = random.normal();
  return deviation;
}

// Diameters of a pair of parts, and what a recording states of them; false: they interfere.
bool draw_diameters(Scene& drawn, RandomStream random) {
  const Tolerance t = *drawn.tolerance;
  const double fibre = t.fibre
                           ? within(*t.fibre, random)
                           : 2 * drawn.world.annulus.fibre_radius + t.fibre_sd * cut_normal(random);
  const double bore = within(t.bore, random);
  if (fibre >= bore) return false;
  // Nor does a fibre go in that leaves a bore as oval too little room.
  const std::optional<double>& ovality = drawn.parameters.ferrule.ovality_um;
  if (ovality && micro * *ovality > kMostOval * (bore - fibre)) return false;
  drawn.tolerance.reset();
  WorldParameters& p = drawn.parameters;
  p.fibre.diameter_um = 1e6 * fibre;
  p.ferrule.bore_diameter_um = 1e6 * bore;
  if (!drawn.document.contains("tangent")) p.numerics.extrapolation_tip = usual_tangent_tip(p);
  if (const auto found = inconsistency(p))
    throw BadInput(drawn.name + ": tolerance: " + found->key + " " + found->rule);
  Json& document = drawn.document;
  document["drawn_from"] = {{"tolerance", document["tolerance"]},
                            {"fibre_diameter_um", document["fibre"]["diameter_um"]},
                            {"ferrule_bore_diameter_um", document["ferrule"]["bore_diameter_um"]}};
  document.erase("tolerance");
  document["fibre"]["diameter_um"] = p.fibre.diameter_um;
  document["ferrule"]["bore_diameter_um"] = p.ferrule.bore_diameter_um;
  return true;
}

// Has the fibre's roll angle, or that of its cleave to it, an effect that chance decides?
bool rolls(const FibreParameters& fibre) noexcept {
  return (fibre.curl_radius_m || fibre.cleave_deg) && !fibre.roll_deg;
}
bool cleaves(const FibreParameters& fibre) noexcept {
  return fibre.cleave_deg && !fibre.cleave_direction_deg;
}

// Where the dotted key is.
Json::json_pointer pointer_to(std::string key) {
  std::replace(key.begin(), key.end(), '.', '/');
  return Json::json_pointer("/" + key);
}

// States a number that chance decided.
void add_number(Json& document, const char* key, double value) {
  document[pointer_to(key)] = value;
  document["drawn_from"]["added"].push_back(key);
}

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
  add_number(drawn.document, "laws.particle.height_um", height_um);
  add_number(drawn.document, "laws.particle.at_um", at_um);
  add_number(drawn.document, "laws.particle.direction_deg", degrees);
}

// How far the core lies from the ferrule's axis: what fibre and ferrule are off, together.
void draw_concentricity(Scene& drawn, RandomStream random) {
  const Joint& joint = drawn.joint;
  const double sd = std::sqrt(joint.core_sd * joint.core_sd + joint.bore_sd * joint.bore_sd);
  const double y_um = random.normal() * 1e6 * sd, z_um = random.normal() * 1e6 * sd;
  drawn.joint.offset = micro * Vector2d(y_um, z_um);
  add_number(drawn.document, "joint.offset_y_um", y_um);
  add_number(drawn.document, "joint.offset_z_um", z_um);
}

double roll_deg(const Scene& scene, std::uint64_t seed, std::uint64_t trial) noexcept {
  const FibreParameters& fibre = scene.parameters.fibre;
  return fibre.roll_deg ? *fibre.roll_deg : 360 * RandomStream(seed, trial, Draw::roll).uniform();
}

// An end that would begin in a wall leans on it at rest, or its inertia would fling it out. Without
// inertia the first step finds that pose.
State leaned_on(World world, const State& start) noexcept {
  world.dynamics = Dynamics::quasi_static;
  State leaned = step(world, start, start.command, 0).state;
  if (!leaned.contact[kEnd].closed && !leaned.contact[kSide].closed) return start;
  return leaned;
}

}  // namespace

std::shared_ptr<const Scene> draw_scene(const Scene& scene, std::uint64_t seed,
                                        std::uint64_t trial) {
  const bool roll = rolls(scene.parameters.fibre);
  const bool entrance =
      scene.sensor.entrance_sd > 0 && !scene.document["sensor"].contains("entrance_error_um");
  const bool cleave = cleaves(scene.parameters.fibre);
  const FerruleParameters& ferrule = scene.parameters.ferrule;
  const bool oval = ferrule.ovality_um && !ferrule.ovality_direction_deg;
  const std::optional<Particle>& law = scene.parameters.laws.particle;
  const bool particle = law && std::isnan(law->height);
  const bool concentricity = (scene.joint.core_sd > 0 || scene.joint.bore_sd > 0) &&
                             !scene.document["joint"].contains("offset_y_um");
  if (!scene.tolerance && !roll && !cleave && !oval && !entrance && !particle && !concentricity)
    return {std::shared_ptr<const Scene>(), &scene};
  const auto drawn = std::make_shared<Scene>(scene);
  if (scene.tolerance && !draw_diameters(*drawn, {seed, trial, Draw::parts})) return nullptr;
  if (roll) {
    drawn->parameters.fibre.roll_deg = roll_deg(scene, seed, trial);
    add_number(drawn->document, "fibre.roll_deg", *drawn->parameters.fibre.roll_deg);
  }
  if (cleave) {
    RandomStream random(seed, trial, Draw::roll);
    random.uniform();  // the roll angle
    drawn->parameters.fibre.cleave_direction_deg = 360 * random.uniform();
    add_number(drawn->document, "fibre.cleave_direction_deg",
               *drawn->parameters.fibre.cleave_direction_deg);
  }
  if (oval) {
    const double direction = 180 * RandomStream(seed, trial, Draw::bore).uniform();
    drawn->parameters.ferrule.ovality_direction_deg = direction;
    add_number(drawn->document, "ferrule.ovality_direction_deg", direction);
  }
  if (entrance) {
    const double um =
        RandomStream(seed, trial, Draw::entrance).normal() * 1e6 * scene.sensor.entrance_sd;
    drawn->sensor.entrance_error = micro * um;
    add_number(drawn->document, "sensor.entrance_error_um", um);
  }
  if (particle) draw_particle(*drawn, {seed, trial, Draw::particle});
  if (concentricity) draw_concentricity(*drawn, {seed, trial, Draw::concentricity});
  if (scene.tolerance) drawn->world = make_world(drawn->parameters);
  drawn->world.end = fibre_end(drawn->parameters.fibre);
  drawn->world.oval = oval_bore(drawn->parameters);
  drawn->world.laws.particle = ferrule::particle(drawn->parameters);
  return drawn;
}

FeasibleTrial feasible_trial(const Scene& scene, std::uint64_t seed, std::uint64_t trial) {
  constexpr std::size_t kMostDraws = 10000;
  FeasibleTrial found{nullptr, trial, 0};
  while (!(found.scene = draw_scene(scene, seed, found.trial))) {
    if (++found.infeasible == kMostDraws)
      throw BadInput(scene.name + ": tolerance: of " + std::to_string(kMostDraws) +
                     " drawn pairs of parts not one fits");
    found.trial += std::uint64_t{1} << 32;
  }
  return found;
}

Json undrawn(Json document) {
  if (!document.contains("drawn_from")) return document;
  const Json from = document["drawn_from"];
  document.erase("drawn_from");
  if (from.contains("tolerance")) {
    document["tolerance"] = from["tolerance"];
    document["fibre"]["diameter_um"] = from["fibre_diameter_um"];
    document["ferrule"]["bore_diameter_um"] = from["ferrule_bore_diameter_um"];
  }
  for (const Json& key : from.value("added", Json::array())) {
    const Json::json_pointer at = pointer_to(key.get<std::string>());
    if (document.contains(at)) document[at.parent_pointer()].erase(at.back());
  }
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
  if (const auto& radius = scene.parameters.fibre.curl_radius_m) {
    const double roll = degree * roll_deg(scene, seed, trial);
    tip += curl(*radius, free_length(scene.parameters),
                {elementary::cos(roll), elementary::sin(roll)});
  }
  const State start = at_rest(scene.world, tip);
  return scene.world.dynamics == Dynamics::inertial ? leaned_on(scene.world, start) : start;
}

}  // namespace ferrule
