#include "sim/scene/read_scene.hpp"

#include <algorithm>
#include <cmath>

#include "sim/base/units.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr double kFarthest = 1e6;  // of a start [um]
constexpr int kUsualNodes = 5;     // of the quadrature along the insertion

// Ranges are wide, so that whatever is in them can be computed with.
using rule::not_negative;
using rule::positive;

// Reads numbers of `f`, each in its unit and with its rule, where their keys are there.
auto optional_number(JsonFields& f) {
  return [&f](const char* key, double unit, const Rule& rule, double& value) {
    if (f.present(key)) f.number(key, rule, value, unit);
  };
}

template <class Part>
void read_solid(JsonFields& f, Part& part) {
  f.number("young_GPa", positive(1e-3, 1e4), part.young_GPa);
  f.number("poisson", rule::between(-1, 0.5, "must be from -1 to 0.5"), part.poisson);
  f.number("shear_GPa", positive(1e-6, 1e4), part.shear_GPa);
}

void read_fibre(JsonFields f, FibreParameters& fibre) {
  f.number("diameter_um", positive(1, 1e5), fibre.diameter_um);
  f.number("density_kg_m3", positive(1, 1e5), fibre.density_kg_m3);
  read_solid(f, fibre);
  f.number("manipulated_length_mm", positive(1e-3, 1e4), fibre.manipulated_length_mm);
  if (f.present("curl_radius_m"))
    f.number("curl_radius_m", positive(1e-2, 1e9), fibre.curl_radius_m.emplace());
  if (f.present("roll_deg"))
    f.number("roll_deg", rule::between(-360, 360, "must be from -360 to 360"),
             fibre.roll_deg.emplace());
  if (f.present("cleave_deg"))
    f.number("cleave_deg", rule::between(0, 10, "must be from 0 to 10"),
             fibre.cleave_deg.emplace());
  if (f.present("edge_um"))
    f.number("edge_um", positive(kSharpestEdge, 1e4), fibre.edge_um.emplace());
  if (f.present("cleave_direction_deg"))
    f.number("cleave_direction_deg", rule::between(-360, 360, "must be from -360 to 360"),
             fibre.cleave_direction_deg.emplace());
  f.depends("roll_deg", {"curl_radius_m", "cleave_deg"});
  f.depends("cleave_direction_deg", {"cleave_deg"});
  f.finish();
}

void read_ferrule(JsonFields f, FerruleParameters& ferrule) {
  f.number("bore_diameter_um", positive(1, 1e5), ferrule.bore_diameter_um);
  f.number("length_mm", positive(1e-3, 1e4), ferrule.length_mm);
  if (f.present("ovality_um"))
    f.number("ovality_um", not_negative(1e5), ferrule.ovality_um.emplace());
  if (f.present("ovality_direction_deg"))
    f.number("ovality_direction_deg", rule::between(-360, 360, "must be from -360 to 360"),
             ferrule.ovality_direction_deg.emplace());
  f.depends("ovality_direction_deg", {"ovality_um"});
  read_solid(f, ferrule);
  f.raw("lead_in");
  if (f.has("lead_in")) {
    LeadIn& lead_in = ferrule.lead_in.emplace();
    JsonFields g = f.object("lead_in");
    g.number("angle_deg", rule::between(1, 179, "must be from 1 to 179 degrees (full angle)"),
             lead_in.angle_deg);
    g.number("diameter_um", positive(1, 1e5), lead_in.diameter_um);
    g.finish();
  }
  f.finish();
}

void read_laws(JsonFields f, Laws& laws) {
  for (const Term term : kAllTerms) {
    const TermInfo& law = info(term);
    if (law.read && f.has(law.name)) law.read(f.object(law.name), laws);
  }
  f.finish();
}

void read_holder(JsonFields f, std::variant<RigidHand, ElasticFibre>& holder) {
  if (f.choice("type", {"rigid_hand", "elastic_fibre"}) == 0) {
    auto& hand = holder.emplace<RigidHand>();
    f.number("stiffness_N_m", positive(1e-9, 1e9), hand.stiffness_N_m);
    f.number("tilt_stiffness_N_m_rad", positive(1e-15, 1e9), hand.tilt_stiffness_N_m_rad);
  } else {
    auto& fibre = holder.emplace<ElasticFibre>();
    f.number("free_length_mm", positive(1e-3, 1e4), fibre.free_length_mm);
    f.number("gripper_stiffness_N_m", positive(1e-6, 1e9), fibre.gripper_stiffness_N_m);
    if (f.present("loss_factor"))
      f.number("loss_factor", rule::between(0, 1, "must be from 0 to 1"), fibre.loss_factor);
  }
  f.finish();
}

// Corrected surface laws are integrated along the insertion; the printed ones know one gap.
bool integrated(const Laws& laws) {
  return std::holds_alternative<VanDerWaals>(laws.van_der_waals) ||
         std::holds_alternative<Electrostatic>(laws.electrostatic) ||
         std::holds_alternative<Capillary>(laws.capillary);
}

constexpr double kUsualEventTravel = 0.1e-9;  // [m], where there are no printed wells

void read_numerics(JsonFields& scene, const Laws& laws, Numerics& numerics) {
  if (scene.present("integrator") && scene.choice("integrator", {"backward_euler", "bdf2"}) == 1)
    numerics.integrator = Integrator::bdf2;
  int order = integrated(laws) ? kUsualNodes : 1;
  if (scene.present("quadrature"))
    order = static_cast<int>(scene.integer("quadrature", 1, kMostNodes));
  numerics.quadrature = Quadrature::gauss_legendre(order);
  if (scene.present("tilted_axes"))
    numerics.closed_form = scene.choice("tilted_axes", {"closed_form", "quadrature"}) == 0;
  if (scene.present("step_s"))
    scene.number("step_s", rule::between(1e-7, 1, "must be from 1e-7 to 1"), numerics.longest_step);
  if (scene.present("event_travel_nm"))
    scene.number("event_travel_nm", positive(1e-6, 1e9), numerics.event_travel, nano);
  else if (!has_printed_wells(laws))
    numerics.event_travel = kUsualEventTravel;
}

void read_world(JsonFields& scene, WorldParameters& world) {
  read_fibre(scene.object("fibre"), world.fibre);
  read_ferrule(scene.object("ferrule"), world.ferrule);
  scene.number("roughness_nm", not_negative(1e5), world.roughness_nm);
  read_laws(scene.object("laws"), world.laws);
  read_holder(scene.object("holder"), world.holder);
  if (scene.present("dynamics") && scene.choice("dynamics", {"quasi_static", "inertial"}) == 1)
    world.dynamics = Dynamics::inertial;
  read_numerics(scene, world.laws, world.numerics);
}

void read_start(JsonFields f, InsertionStart& start) {
  f.number("distance_um", not_negative(kFarthest), start.distance, micro);
  const Vector2d mean = f.pair("lateral_mean_um");
  if (!(mean.cwiseAbs().maxCoeff() <= kFarthest))
    f.refuse("lateral_mean_um", "must be two numbers from -1e6 to 1e6");
  start.lateral = start.lateral_mean = micro * mean;
  start.tilt.setZero();
  f.number("lateral_sd_um", not_negative(kFarthest), start.lateral_sd, micro);
  f.number("tilt_sd_mrad", rule::between(0, 100, "must be from 0 to 100"), start.tilt_sd, milli);
  if (f.present("vision_sd_um"))
    f.number("vision_sd_um", not_negative(kFarthest), start.vision_sd, micro);
  if (f.present("vision_sd_um") || f.present("vision_y_um")) start.vision = Vector2d::Zero();
  const auto number = optional_number(f);
  const Rule lateral = rule::between(-kFarthest, kFarthest, "must be from -1e6 to 1e6");
  number("y_um", micro, lateral, start.lateral.x());
  number("z_um", micro, lateral, start.lateral.y());
  const Rule tilt = rule::between(-300, 300, "must be from -300 to 300");
  number("tilt_y_mrad", milli, tilt, start.tilt.x());
  number("tilt_z_mrad", milli, tilt, start.tilt.y());
  f.depends("vision_y_um", {"vision_z_um"});
  f.depends("vision_z_um", {"vision_y_um"});
  if (start.vision) {
    number("vision_y_um", micro, lateral, start.vision->x());
    number("vision_z_um", micro, lateral, start.vision->y());
  }
  f.finish();
}

// Of pairs of parts, as scenes before 0.9.0 state it: what is drawn of each diameter.
void read_tolerance(JsonFields f, const Json& fibre_um, std::vector<DrawnNumber>& drawn) {
  const auto add = [&](const char* key, const Json& distribution) {
    drawn.push_back({.key = key, .distribution = *Distribution::read(distribution)});
  };
  const auto band = [&](const char* key) {
    const Vector2d um = f.pair(key);
    if (!(um[0] >= 1 && um[1] >= um[0] && um[1] <= 1e5))
      f.refuse(key,
               "must be the smallest and the largest diameter, both positive, from 1 to 100000");
    return Json{{"uniform", {um[0], um[1]}}};
  };
  if (f.present("fibre_diameter_um")) {
    if (f.present("fibre_diameter_sd_um"))
      f.refuse("fibre_diameter_um",
               "does not go with fibre_diameter_sd_um: it is one or the other");
    add("fibre.diameter_um", band("fibre_diameter_um"));
  } else if (f.present("fibre_diameter_sd_um")) {
    const double sd_um = f.number("fibre_diameter_sd_um", not_negative(1e3));
    add("fibre.diameter_um", {{"normal", {fibre_um, sd_um}}});
  }
  if (f.present("bore_diameter_um")) add("ferrule.bore_diameter_um", band("bore_diameter_um"));
  f.finish();
}

// What is only said: what the numbers of a drawn scene were drawn from.
void read_drawn_from(JsonFields f, const Json& document) {
  const auto is_there = [&](const std::string& key) {
    return key == "tolerance" || document.contains(pointer_to(key));
  };
  if (f.present("was")) {
    const Json& was = f.raw("was");
    bool known = was.is_object();
    if (known)
      for (const auto& [key, value] : was.items()) known = known && is_there(key);
    if (!known) f.refuse("was", "must have keys of the scene, and what stood there");
  }
  if (f.present("tolerance")) {  // as recordings before 0.9.0 have it
    std::vector<DrawnNumber> drawn;
    read_tolerance(f.object("tolerance"), 0, drawn);
    for (const char* key : {"fibre_diameter_um", "ferrule_bore_diameter_um"})
      f.number(key, positive(1, 1e5));
  }
  if (f.present("added"))
    for (const Json& key : f.raw("added"))
      if (std::find(kDrawnKeys.begin(), kDrawnKeys.end(), key) == kDrawnKeys.end())
        f.refuse("added", "must be a list of keys that chance may add");
  f.finish();
}

void read_sensor(JsonFields f, ForceSensorModel& sensor) {
  const auto number = optional_number(f);
  number("noise_uN", micro, not_negative(1e9), sensor.noise);
  number("bias_uN", micro, not_negative(1e9), sensor.bias);
  number("bandwidth_Hz", 1, positive(1e-3, 1e9), sensor.bandwidth);
  number("resolution_uN", micro, not_negative(1e9), sensor.resolution);
  number("moment_arm_mm", milli, positive(1e-6, 1e6), sensor.arm);
  number("bias_walk_uN_sqrt_s", micro, not_negative(1e9), sensor.bias_walk);
  number("gain_error", 1, not_negative(1), sensor.gain_error);
  number("cross_talk", 1, not_negative(1), sensor.cross_talk);
  number("temperature_drift_uN_K", micro, not_negative(1e9), sensor.drift);
  number("temperature_rate_K_s", 1, not_negative(1e3), sensor.temperature_rate);
  number("vibration_uN", micro, not_negative(1e9), sensor.vibration);
  number("vibration_Hz", 1, positive(1e-3, 1e9), sensor.vibration_frequency);
  number("tare_s", 1, not_negative(1e3), sensor.tare_time);
  number("dead_band_uN", micro, not_negative(1e9), sensor.dead_band);
  number("entrance_sd_um", micro, not_negative(1e6), sensor.entrance_sd);
  number("entrance_error_um", micro, rule::between(-1e7, 1e7, "must be from -1e7 to 1e7"),
         sensor.entrance_error);
  f.depends("temperature_drift_uN_K", {"temperature_rate_K_s"});
  f.depends("temperature_rate_K_s", {"temperature_drift_uN_K"});
  f.depends("vibration_Hz", {"vibration_uN"});
  f.finish();
}

void read_hand(JsonFields f, HandErrors& hand) {
  const auto number = optional_number(f);
  number("gain", 1, rule::between(0.01, 100, "must be from 0.01 to 100"), hand.gain);
  number("delay_ms", milli, not_negative(1e3), hand.delay);
  number("smoothing_ms", milli, not_negative(1e5), hand.smoothing);
  number("dead_zone_um_s", micro, not_negative(1e9), hand.dead_zone);
  const Rule offset = rule::between(-kFarthest, kFarthest, "must be from -1e6 to 1e6");
  number("grasp_y_um", micro, offset, hand.grasp.x());
  number("grasp_z_um", micro, offset, hand.grasp.y());
  const Rule tilt = rule::between(-100, 100, "must be from -100 to 100");
  number("grasp_tilt_y_mrad", milli, tilt, hand.grasp_tilt.x());
  number("grasp_tilt_z_mrad", milli, tilt, hand.grasp_tilt.y());
  f.finish();
}

void read_limits(JsonFields f, Limits& limits) {
  f.number("force_uN", positive(1e-6, 1e12), limits.force, micro);
  f.number("speed_um_s", positive(1e-6, 1e9), limits.speed, micro);
  Rule time = rule::between(0, 3600, "must be positive and at most 3600");
  time.low_open = true;
  f.number("time_s", time, limits.time);
  if (f.present("proof_stress_GPa"))
    f.number("proof_stress_GPa", positive(1e-9, 1e6), limits.proof_stress, giga);
  f.finish();
}

void read_tangent(JsonFields& fields, Scene& scene) {
  Numerics& numerics = scene.parameters.numerics;
  numerics.extrapolation_tip = usual_tangent_tip(scene.parameters);
  numerics.extrapolation_force = kUsualTangent * scene.limits.force;
  if (!fields.present("tangent")) return;
  JsonFields f = fields.object("tangent");
  f.number("tip_nm", not_negative(1e6), numerics.extrapolation_tip, nano);
  f.number("force_uN", not_negative(1e6), numerics.extrapolation_force, micro);
  f.finish();
}

void read_scaling(JsonFields f, ScalingRanges& scaling) {
  f.number("hand_range_mm", positive(1e-6, 1e6), scaling.hand_range, milli);
  f.number("tip_range_um", positive(1e-6, 1e6), scaling.tip_range, micro);
  f.number("hand_force_N", positive(1e-9, 1e6), scaling.hand_force);
  f.number("tip_force_uN", positive(1e-9, 1e12), scaling.tip_force, micro);
  f.finish();
}

void read_success(JsonFields f, Success& success) {
  f.number("depth_um", positive(1e-6, 1e7), success.depth, micro);
  if (f.present("loss_dB")) f.number("loss_dB", positive(1e-9, 1e6), success.loss_dB);
  f.finish();
}

// A number, or a list of `count` numbers, one for each wavelength: into `value` the first one.
void read_at_wavelengths(JsonFields& f, const char* key, std::size_t count, double unit,
                         const Rule& rule, double& value) {
  if (!f.raw(key).is_array()) return f.number(key, rule, value, unit);
  const Json& list = f.raw(key);
  const bool numbers = std::all_of(list.begin(), list.end(), [&](const Json& each) {
    return each.is_number() && rule.allows(each.get<double>());
  });
  if (!numbers || list.empty())
    f.refuse(key, "must be a number, or a list of numbers; each " + rule.text);
  if (list.size() != count)
    f.refuse(key, "must be one number, or as many as wavelength_nm has: " + std::to_string(count));
  value = unit * list.front().get<double>();
}

void read_joint(JsonFields f, Joint& joint) {
  const auto number = optional_number(f);
  std::size_t wavelengths = 1;
  if (f.present("wavelength_nm")) {
    const Json& stated = f.raw("wavelength_nm");
    wavelengths = stated.is_array() ? stated.size() : 1;
    read_at_wavelengths(f, "wavelength_nm", wavelengths, nano, positive(100, 1e5),
                        joint.wavelength);
  }
  number("index", 1, rule::between(1, 5, "must be from 1 to 5"), joint.index);
  const auto mode_field = [&](const char* key, double& radius) {
    read_at_wavelengths(f, key, wavelengths, 0.5 * micro, positive(0.1, 1e4), radius);
  };
  if (f.present("mode_field_diameter_um")) mode_field("mode_field_diameter_um", joint.mode_radius);
  if (f.present("partner_mode_field_diameter_um"))
    mode_field("partner_mode_field_diameter_um", joint.partner_mode_radius.emplace());
  number("gap_um", micro, not_negative(1e6), joint.gap);
  number("core_concentricity_sd_um", micro, not_negative(1e3), joint.core_sd);
  number("bore_concentricity_sd_um", micro, not_negative(1e3), joint.bore_sd);
  const Rule offset = rule::between(-1e5, 1e5, "must be from -1e5 to 1e5");
  number("offset_y_um", micro, offset, joint.offset.x());
  number("offset_z_um", micro, offset, joint.offset.y());
  f.depends("offset_y_um", {"offset_z_um"});
  f.depends("offset_z_um", {"offset_y_um"});
  f.finish();
}

}  // namespace

std::optional<Inconsistency> inconsistency(const Scene& scene) {
  if (auto found = inconsistency(scene.parameters)) return found;
  if (scene.success.depth > milli * scene.parameters.ferrule.length_mm)
    return {{"success.depth_um", "must not exceed the ferrule's length (ferrule.length_mm)"}};
  const ScalingRanges& r = scene.scaling;
  for (const double ratio : {r.hand_range / r.tip_range, r.hand_force / r.tip_force})
    if (!(ratio > 1e-12 && ratio < 1e12))
      return {{"scaling", "the ranges of hand and tip must be within a factor of 1e12"}};
  return std::nullopt;
}

void read_scene(JsonFields& fields, const Json& document, Scene& scene) {
  if (fields.present("$schema")) fields.text("$schema");
  scene.name = fields.line("name", 100);
  if (fields.present("about")) fields.text("about");
  read_world(fields, scene.parameters);
  read_start(fields.object("start"), scene.start);
  if (fields.present("tolerance"))
    read_tolerance(fields.object("tolerance"), scene.parameters.fibre.diameter_um, scene.drawn);
  if (fields.present("drawn_from")) read_drawn_from(fields.object("drawn_from"), document);
  read_sensor(fields.object("sensor"), scene.sensor);
  if (fields.present("hand")) read_hand(fields.object("hand"), scene.hand);
  read_limits(fields.object("limits"), scene.limits);
  read_tangent(fields, scene);
  read_success(fields.object("success"), scene.success);
  if (fields.present("joint")) read_joint(fields.object("joint"), scene.joint);
  read_scaling(fields.object("scaling"), scene.scaling);
  if (fields.present("cue")) scene.cue = fields.flag("cue");
  if (fields.present("planned_accuracy")) fields.number("planned_accuracy", positive(1e-6, 0.5));
  if (fields.present("planned_error_bound"))
    fields.number("planned_error_bound", not_negative(1e9));
  if (fields.present("accuracy"))
    fields.number("accuracy", rule::between(1e-6, 0.5, "must be from 1e-6 to 0.5"),
                  scene.accuracy.emplace());
  fields.finish();
}

}  // namespace ferrule
