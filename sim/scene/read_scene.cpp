#include "sim/scene/read_scene.hpp"

#include <algorithm>
#include <cmath>

#include "sim/base/units.hpp"
#include "sim/scene/scene_keys.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr int kUsualNodes = 5;        // of the quadrature along the insertion
constexpr double kMostHanging = 0.3;  // tilt of the end in free air [rad]

void read_fibre(JsonFields f, Scene& scene) {
  read_numbers(f,
               {"diameter_um", "density_kg_m3", "young_GPa", "poisson", "shear_GPa",
                "manipulated_length_mm"},
               scene);
  read_numbers_if_there(
      f, {"curl_radius_m", "roll_deg", "cleave_deg", "edge_um", "cleave_direction_deg"}, scene);
  f.depends("roll_deg", {"curl_radius_m", "cleave_deg"});
  f.depends("cleave_direction_deg", {"cleave_deg"});
  f.finish();
}

void read_ferrule(JsonFields f, Scene& scene) {
  read_numbers(f, {"bore_diameter_um", "length_mm"}, scene);
  read_numbers_if_there(f, {"ovality_um", "ovality_direction_deg"}, scene);
  f.depends("ovality_direction_deg", {"ovality_um"});
  read_numbers(f, {"young_GPa", "poisson", "shear_GPa"}, scene);
  f.raw("lead_in");
  if (f.has("lead_in")) {
    scene.parameters.ferrule.lead_in.emplace();
    JsonFields cone = f.object("lead_in");
    read_numbers(cone, {"angle_deg", "diameter_um"}, scene);
    cone.finish();
  }
  f.finish();
}

void read_laws(JsonFields f, Scene& scene) {
  for (const Term term : kAllTerms) {
    const TermInfo& law = info(term);
    if (law.read && f.has(law.name)) law.read(f.object(law.name), scene);
  }
  f.finish();
}

void read_holder(JsonFields f, Scene& scene) {
  if (f.choice("type", {"rigid_hand", "elastic_fibre"}) == 0) {
    scene.parameters.holder = RigidHand{};
    read_numbers(f, {"stiffness_N_m", "tilt_stiffness_N_m_rad"}, scene);
  } else {
    scene.parameters.holder = ElasticFibre{};
    read_numbers(f, {"free_length_mm", "gripper_stiffness_N_m"}, scene);
    read_numbers_if_there(f, {"loss_factor"}, scene);
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

void read_numerics(JsonFields& fields, Scene& scene) {
  Numerics& numerics = scene.parameters.numerics;
  const Laws& laws = scene.parameters.laws;
  if (fields.present("integrator") && fields.choice("integrator", {"backward_euler", "bdf2"}) == 1)
    numerics.integrator = Integrator::bdf2;
  numerics.quadrature = Quadrature::gauss_legendre(integrated(laws) ? kUsualNodes : 1);
  if (!has_printed_wells(laws)) numerics.event_travel = kUsualEventTravel;
  read_numbers_if_there(fields, {"quadrature"}, scene);
  if (fields.present("tilted_axes"))
    numerics.closed_form = fields.choice("tilted_axes", {"closed_form", "quadrature"}) == 0;
  read_numbers_if_there(fields, {"step_s", "event_travel_nm"}, scene);
}

void read_world(JsonFields& fields, Scene& scene) {
  read_fibre(fields.object("fibre"), scene);
  read_ferrule(fields.object("ferrule"), scene);
  read_numbers(fields, {"roughness_nm"}, scene);
  read_laws(fields.object("laws"), scene);
  read_holder(fields.object("holder"), scene);
  if (fields.present("dynamics") && fields.choice("dynamics", {"quasi_static", "inertial"}) == 1)
    scene.parameters.dynamics = Dynamics::inertial;
  read_numerics(fields, scene);
}

void read_start(JsonFields f, Scene& scene) {
  InsertionStart& start = scene.start;
  read_numbers(f, {"distance_um"}, scene);
  const Vector2d mean = f.pair("lateral_mean_um");
  for (int i = 0; i < 2; ++i)
    if (!set_number(scene, "start.lateral_mean_um." + std::to_string(i), mean[i]))
      f.refuse("lateral_mean_um", "must be two numbers from -1e6 to 1e6");
  start.tilt.setZero();
  read_numbers(f, {"lateral_sd_um", "tilt_sd_mrad"}, scene);
  read_numbers_if_there(f, {"vision_sd_um", "y_um", "z_um", "tilt_y_mrad", "tilt_z_mrad"}, scene);
  if (f.present("vision_sd_um")) start.vision = Vector2d::Zero();
  f.depends("vision_y_um", {"vision_z_um"});
  f.depends("vision_z_um", {"vision_y_um"});
  read_numbers_if_there(f, {"vision_y_um", "vision_z_um"}, scene);
  f.finish();
}

// Of pairs of parts, as scenes before 0.9.0 state it: what is drawn of each diameter.
void read_tolerance(JsonFields f, double fibre_um, std::vector<DrawnNumber>& drawn) {
  const auto add = [&](const char* key, const Distribution& distribution) {
    drawn.push_back({.key = key, .distribution = distribution});
  };
  const auto band = [&](const char* key) {
    const Vector2d um = f.pair(key);
    if (!(um[0] >= 1 && um[1] >= um[0] && um[1] <= 1e5))
      f.refuse(key,
               "must be the smallest and the largest diameter, both positive, from 1 to 100000");
    return Distribution::between(um[0], um[1]);
  };
  if (f.present("fibre_diameter_um")) {
    if (f.present("fibre_diameter_sd_um"))
      f.refuse("fibre_diameter_um",
               "does not go with fibre_diameter_sd_um: it is one or the other");
    add("fibre.diameter_um", band("fibre_diameter_um"));
  } else if (f.present("fibre_diameter_sd_um")) {
    const double sd_um = f.number("fibre_diameter_sd_um", rule::not_negative(1e3));
    add("fibre.diameter_um", Distribution::about(fibre_um, sd_um));
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
      f.number(key, rule::positive(1, 1e5));
  }
  if (f.present("added"))
    for (const Json& key : f.raw("added")) {
      const SceneKey* added = key.is_string() ? find_scene_key(key) : nullptr;
      if (!added || !added->chance.may_add())
        f.refuse("added", "must be a list of keys that chance may add");
    }
  f.finish();
}

void read_sensor(JsonFields f, Scene& scene) {
  read_numbers_if_there(
      f,
      {"noise_uN", "bias_uN", "bandwidth_Hz", "resolution_uN", "moment_arm_mm",
       "bias_walk_uN_sqrt_s", "gain_error", "cross_talk", "temperature_drift_uN_K",
       "temperature_rate_K_s", "vibration_uN", "vibration_Hz", "tare_s", "dead_band_uN",
       "entrance_sd_um", "entrance_error_um"},
      scene);
  f.depends("temperature_drift_uN_K", {"temperature_rate_K_s"});
  f.depends("temperature_rate_K_s", {"temperature_drift_uN_K"});
  f.depends("vibration_Hz", {"vibration_uN"});
  f.finish();
}

void read_joint(JsonFields f, Scene& scene) {
  std::size_t wavelengths = 1;
  if (f.present("wavelength_nm") && f.raw("wavelength_nm").is_array())
    wavelengths = f.raw("wavelength_nm").size();
  for (const char* key :
       {"wavelength_nm", "mode_field_diameter_um", "partner_mode_field_diameter_um"})
    if (f.present(key)) read_number_or_list(f, key, wavelengths, "wavelength_nm", scene);
  read_numbers_if_there(f,
                        {"index", "gap_um", "core_concentricity_sd_um", "bore_concentricity_sd_um",
                         "offset_y_um", "offset_z_um"},
                        scene);
  f.depends("offset_y_um", {"offset_z_um"});
  f.depends("offset_z_um", {"offset_y_um"});
  f.finish();
}

// A section that holds only numbers: some that must be there, others that may.
void read_section(JsonFields f, std::initializer_list<const char*> keys,
                  std::initializer_list<const char*> if_there, Scene& scene) {
  read_numbers(f, keys, scene);
  read_numbers_if_there(f, if_there, scene);
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
  read_world(fields, scene);
  read_start(fields.object("start"), scene);
  if (fields.present("tolerance"))
    read_tolerance(fields.object("tolerance"), scene.parameters.fibre.diameter_um, scene.drawn);
  if (fields.present("drawn_from")) read_drawn_from(fields.object("drawn_from"), document);
  read_sensor(fields.object("sensor"), scene);
  if (fields.present("hand"))
    read_section(fields.object("hand"), {},
                 {"gain", "delay_ms", "smoothing_ms", "dead_zone_um_s", "grasp_y_um", "grasp_z_um",
                  "grasp_tilt_y_mrad", "grasp_tilt_z_mrad"},
                 scene);
  read_section(fields.object("limits"), {"force_uN", "speed_um_s", "time_s"}, {"proof_stress_GPa"},
               scene);
  if (fields.present("tangent"))
    read_section(fields.object("tangent"), {"tip_nm", "force_uN"}, {}, scene);
  read_section(fields.object("success"), {"depth_um"}, {"loss_dB"}, scene);
  if (fields.present("joint")) read_joint(fields.object("joint"), scene);
  read_section(fields.object("scaling"),
               {"hand_range_mm", "tip_range_um", "hand_force_N", "tip_force_uN"}, {}, scene);
  if (fields.present("cue")) scene.cue = fields.flag("cue");
  read_numbers_if_there(fields, {"planned_accuracy", "planned_error_bound", "accuracy"}, scene);
  fields.finish();
}

std::optional<Inconsistency> resolve(Scene& scene) {
  if (auto found = inconsistency(scene)) return found;
  if (!states(scene, "tangent.tip_nm")) {
    Numerics& numerics = scene.parameters.numerics;
    numerics.extrapolation_tip = usual_tangent_tip(scene.parameters);
    numerics.extrapolation_force = kUsualTangent * scene.limits.force;
  }
  scene.world = make_world(scene.parameters);
  if (scene.world.holder.sag.tail<2>().norm() > kMostHanging)
    return {{"holder.free_length_mm",
             "must be so short that the fibre's end hangs tilted by no more than " +
                 Json(kMostHanging).dump() + " rad under its weight: tilts are taken as small"}};
  return std::nullopt;
}

}  // namespace ferrule
