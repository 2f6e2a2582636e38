#include "sim/scene/scene.hpp"

#include <cmath>
#include <numbers>
#include <sstream>

#include "sim/plan/plan.hpp"
#include "sim/scene/shipped_files.hpp"

namespace ferrule {
namespace {

constexpr ShippedFiles kScenes = {"scenes", "scene file", "scene"};

constexpr double nano = 1e-9, micro = 1e-6, milli = 1e-3, giga = 1e9;
constexpr double degree = std::numbers::pi / 180;
constexpr double kFarthest = 1e6;  // of a start [um]
constexpr int kUsualNodes = 5;     // of the quadrature along the insertion

// Ranges: wide, so that whatever is in them can be computed with.
Rule range(double low, double high, const char* must_be) {
  std::ostringstream text;
  text << must_be << ", from " << low << " to " << high;
  return rule::between(low, high, text.str());
}
Rule positive(double low, double high) {
  return range(low, high, "must be positive");
}
Rule not_negative(double high) {
  return range(0, high, "must not be negative");
}

Form read_form(JsonFields& law) {
  return law.choice("form", {"printed", "corrected"}) == 0 ? Form::printed : Form::corrected;
}

// Liquid in the gap has no printed drag or meniscus.
Form only_corrected(JsonFields& law) {
  law.choice("form", {"corrected"});
  return Form::corrected;
}

double read_contact_angle(JsonFields& law) {
  Rule wetting = rule::between(0, 90, "must be at least 0 and below 90 degrees");
  wetting.high_open = true;
  return degree * law.number("contact_angle_deg", wetting);
}

Capillary read_capillary(JsonFields f) {
  Capillary law;
  law.form = read_form(f);
  law.surface_tension = f.number("surface_tension_N_m", positive(1e-30, 100));
  law.contact_angle = read_contact_angle(f);
  law.film = nano * f.number("film_nm", positive(1e-3, 1e6));
  // Needed by the corrected form; the printed one may carry them along.
  if (law.form == Form::corrected || f.present("volume_per_length_m2"))
    law.volume = f.number("volume_per_length_m2", positive(1e-20, 1e-6));
  if (law.form == Form::corrected || f.present("rupture_nm")) {
    law.rupture = nano * f.number("rupture_nm", positive(1e-3, 1e6));
    if (!(law.rupture > 2 * law.film))
      f.refuse("rupture_nm", "must be more than twice film_nm, where a bridge forms");
  }
  f.finish();
  return law;
}

Adhesion read_adhesion(JsonFields f, double modulus, double fibre_radius) {
  Adhesion law;
  law.form = read_form(f);
  const bool printed = law.form == Form::printed;
  law.work_of_adhesion = f.number("work_of_adhesion_J_m2", positive(1e-9, 1e3));
  law.maugis_lambda =
      f.number("maugis_lambda", printed ? rule::between(0.12, 5.8, "must be from 0.12 to 5.8")
                                        : rule::between(0.01, 100, "must be from 0.01 to 100"));
  law.m = 1;
  if (printed || f.present("m"))
    law.m = f.number("m", rule::between(1, 1e3, "must be at least 1, at most 1000"));
  law.reduced_modulus = modulus;
  law.radius = fibre_radius;
  if (f.present("radius_um")) {
    const double radius = micro * f.number("radius_um", positive(1e-3, 1e6));
    if (!printed) law.radius = radius;
  }
  f.finish();
  if (!printed)
    law.contact = std::make_shared<const MaugisContact>(law.maugis_lambda, law.work_of_adhesion,
                                                        law.reduced_modulus, law.radius);
  return law;
}

// `friction` comes with the shear moduli.
void read_laws(JsonFields laws, World& world, Friction friction, double modulus) {
  if (laws.has("van_der_waals")) {
    JsonFields f = laws.object("van_der_waals");
    world.van_der_waals = {read_form(f), f.number("hamaker_J", positive(1e-40, 1e-15))};
    f.finish();
  }
  if (laws.has("electrostatic")) {
    JsonFields f = laws.object("electrostatic");
    world.electrostatic = {read_form(f), f.number("voltage_V", not_negative(1e5))};
    f.finish();
  }
  if (laws.has("gravity")) {
    JsonFields f = laws.object("gravity");
    world.gravity = {read_form(f)};
    f.finish();
  }
  if (laws.has("capillary"))
    world.capillary = prepare(read_capillary(laws.object("capillary")), world.annulus);
  if (laws.has("adhesion"))
    world.adhesion = read_adhesion(laws.object("adhesion"), modulus, world.annulus.fibre_radius);
  if (laws.has("friction")) {
    JsonFields f = laws.object("friction");
    friction.form = read_form(f);
    friction.burgers = nano * f.number("burgers_nm", positive(1e-6, 1e3));
    f.finish();
    world.friction = friction;
  }
  if (laws.has("drag")) {
    JsonFields f = laws.object("drag");
    world.drag = {only_corrected(f), f.number("viscosity_Pa_s", positive(1e-30, 1e6))};
    f.finish();
  }
  if (laws.has("meniscus")) {
    JsonFields f = laws.object("meniscus");
    world.meniscus = {only_corrected(f), f.number("surface_tension_N_m", positive(1e-30, 100)),
                      read_contact_angle(f)};
    f.finish();
  }
  laws.finish();
}

Holder read_holder(JsonFields f, const World& world) {
  Holder holder;
  if (f.choice("type", {"rigid_hand", "elastic_fibre"}) == 0) {
    holder = rigid_hand(f.number("stiffness_N_m", positive(1e-9, 1e9)),
                        f.number("tilt_stiffness_N_m_rad", positive(1e-15, 1e9)), world.fibre,
                        world.fibre_young, world.gravity);
  } else {
    holder = elastic_fibre(milli * f.number("free_length_mm", positive(1e-3, 1e4)),
                           f.number("gripper_stiffness_N_m", positive(1e-6, 1e9)), world.fibre,
                           world.fibre_young, world.gravity);
  }
  f.finish();
  return holder;
}

World read_world(JsonFields& scene) {
  const Rule poisson = rule::between(-1, 0.5, "must be from -1 to 0.5");
  World world{};
  Friction friction{};

  JsonFields fibre = scene.object("fibre");
  const double fibre_diameter = fibre.number("diameter_um", positive(1, 1e5));
  world.annulus.fibre_radius = 0.5 * micro * fibre_diameter;
  world.fibre.radius = world.annulus.fibre_radius;
  world.fibre.density = fibre.number("density_kg_m3", positive(1, 1e5));
  world.fibre_young = giga * fibre.number("young_GPa", positive(1e-6, 1e4));
  const double fibre_poisson = fibre.number("poisson", poisson);
  friction.shear_fibre = giga * fibre.number("shear_GPa", positive(1e-6, 1e4));
  world.fibre.length = milli * fibre.number("manipulated_length_mm", positive(1e-3, 1e4));
  fibre.finish();

  JsonFields ferrule = scene.object("ferrule");
  const double bore_diameter = ferrule.number("bore_diameter_um", positive(1, 1e5));
  if (!(bore_diameter > fibre_diameter))
    ferrule.refuse("bore_diameter_um", "must be wider than the fibre (fibre.diameter_um = " +
                                           Json(fibre_diameter).dump() + ")");
  world.annulus.bore_radius = 0.5 * micro * bore_diameter;
  world.profile = {world.annulus.bore_radius, 0, 0,
                   milli * ferrule.number("length_mm", positive(1e-3, 1e4))};
  const double ferrule_young = giga * ferrule.number("young_GPa", positive(1e-6, 1e4));
  const double ferrule_poisson = ferrule.number("poisson", poisson);
  friction.shear_ferrule = giga * ferrule.number("shear_GPa", positive(1e-6, 1e4));
  ferrule.raw("lead_in");
  if (ferrule.has("lead_in")) {
    JsonFields lead_in = ferrule.object("lead_in");
    const Rule angle = rule::between(1, 179, "must be from 1 to 179 degrees (full angle)");
    const double tangent = std::tan(0.5 * degree * lead_in.number("angle_deg", angle));
    const double diameter = lead_in.number("diameter_um", positive(1, 1e5));
    if (!(diameter > bore_diameter))
      lead_in.refuse("diameter_um", "must be wider than the bore (ferrule.bore_diameter_um = " +
                                        Json(bore_diameter).dump() + ")");
    world.profile.lead_in_tangent = tangent;
    world.profile.lead_in_length = 0.5 * micro * (diameter - bore_diameter) / tangent;
    lead_in.finish();
  }
  ferrule.finish();

  world.annulus.roughness = nano * scene.number("roughness_nm", not_negative(1e5));

  const double modulus =
      reduced_modulus(world.fibre_young, fibre_poisson, ferrule_young, ferrule_poisson);
  read_laws(scene.object("laws"), world, friction, modulus);
  if (!world.adhesion || world.adhesion->form == Form::printed)
    world.wall = {modulus, world.annulus.fibre_radius, world.adhesion ? kPrintedDepth : 0.0};

  world.holder = read_holder(scene.object("holder"), world);
  if (scene.present("dynamics") && scene.choice("dynamics", {"quasi_static", "inertial"}) == 1)
    world.dynamics = Dynamics::inertial;
  if (scene.present("integrator") && scene.choice("integrator", {"backward_euler", "bdf2"}) == 1)
    world.integrator = Integrator::bdf2;
  // Between tilted axes the corrected laws are integrated along the insertion; the printed ones
  // know one gap.
  const auto corrected = [](const auto& law) { return law && law->form == Form::corrected; };
  const bool integrated = corrected(world.van_der_waals) || corrected(world.electrostatic) ||
                          corrected(world.capillary);
  int order = integrated ? kUsualNodes : 1;
  if (scene.present("quadrature"))
    order = static_cast<int>(scene.integer("quadrature", 1, kMostNodes));
  world.quadrature = Quadrature::gauss_legendre(order);
  if (scene.present("tilted_axes"))
    world.closed_form = scene.choice("tilted_axes", {"closed_form", "quadrature"}) == 0;
  if (scene.present("step_s"))
    world.longest_step = scene.number("step_s", rule::between(1e-7, 1, "must be from 1e-7 to 1"));
  if (scene.present("event_travel_nm"))
    world.event_travel = nano * scene.number("event_travel_nm", positive(1e-6, 1e9));
  return world;
}

Tolerance read_tolerance(JsonFields f) {
  Tolerance t{};
  t.fibre_sd = micro * f.number("fibre_diameter_sd_um", not_negative(1e3));
  const Vector2d bore = f.pair("bore_diameter_um");
  if (!(bore[0] >= 1 && bore[1] >= bore[0] && bore[1] <= 1e5))
    f.refuse("bore_diameter_um",
             "must be the smallest and the largest diameter, both positive, from 1 to 100000");
  t.bore_low = micro * bore[0];
  t.bore_high = micro * bore[1];
  f.finish();
  return t;
}

ForceSensorModel read_sensor(JsonFields f) {
  ForceSensorModel sensor;
  const auto number = [&](const char* key, double unit, const Rule& rule, double& value) {
    if (f.present(key)) value = unit * f.number(key, rule);
  };
  number("noise_uN", micro, not_negative(1e9), sensor.noise);
  number("bias_uN", micro, not_negative(1e9), sensor.bias);
  number("bandwidth_Hz", 1, positive(1e-3, 1e9), sensor.bandwidth);
  number("resolution_uN", micro, not_negative(1e9), sensor.resolution);
  number("moment_arm_mm", milli, positive(1e-6, 1e6), sensor.arm);
  f.finish();
  return sensor;
}

}  // namespace

Scene parse_scene(const Json& document, const std::string& file, Planning planning) {
  JsonFields fields(document, file);
  Scene scene{};
  scene.document = document;
  if (fields.present("$schema")) fields.text("$schema");
  scene.name = fields.text("name");
  if (fields.present("about")) fields.text("about");
  scene.world = read_world(fields);

  JsonFields start = fields.object("start");
  scene.start.distance = micro * start.number("distance_um", not_negative(kFarthest));
  const Vector2d mean = start.pair("lateral_mean_um");
  if (!(mean.cwiseAbs().maxCoeff() <= kFarthest))
    start.refuse("lateral_mean_um", "must be two numbers from -1e6 to 1e6");
  scene.start.lateral_mean = micro * mean;
  scene.start.lateral_sd = micro * start.number("lateral_sd_um", not_negative(kFarthest));
  scene.start.tilt_sd =
      milli * start.number("tilt_sd_mrad", rule::between(0, 100, "must be from 0 to 100"));
  start.finish();

  if (fields.present("tolerance")) scene.tolerance = read_tolerance(fields.object("tolerance"));
  scene.sensor = read_sensor(fields.object("sensor"));

  JsonFields limits = fields.object("limits");
  scene.limits.force = micro * limits.number("force_uN", positive(1e-6, 1e12));
  scene.limits.speed = micro * limits.number("speed_um_s", positive(1e-6, 1e9));
  Rule time = rule::between(0, 3600, "must be positive and at most 3600");
  time.low_open = true;
  scene.limits.time = limits.number("time_s", time);
  if (limits.present("proof_stress_GPa"))
    scene.limits.proof_stress = giga * limits.number("proof_stress_GPa", positive(1e-9, 1e6));
  limits.finish();

  JsonFields success = fields.object("success");
  scene.success.depth = micro * success.number("depth_um", positive(1e-6, 1e7));
  if (scene.success.depth > scene.world.profile.length)
    success.refuse("depth_um", "must not exceed the ferrule's length (ferrule.length_mm)");
  success.finish();

  JsonFields scaling = fields.object("scaling");
  scene.scaling.hand_range = milli * scaling.number("hand_range_mm", positive(1e-6, 1e6));
  scene.scaling.tip_range = micro * scaling.number("tip_range_um", positive(1e-6, 1e6));
  scene.scaling.hand_force = scaling.number("hand_force_N", positive(1e-9, 1e6));
  scene.scaling.tip_force = micro * scaling.number("tip_force_uN", positive(1e-9, 1e12));
  scaling.finish();
  const ScalingRanges& r = scene.scaling;
  for (const double ratio : {r.hand_range / r.tip_range, r.hand_force / r.tip_force})
    if (!(ratio > 1e-12 && ratio < 1e12))
      fields.refuse("scaling", "the ranges of hand and tip must be within a factor of 1e12");
  if (fields.present("planned_accuracy")) fields.number("planned_accuracy", positive(1e-6, 0.5));
  if (fields.present("planned_error_bound"))
    fields.number("planned_error_bound", not_negative(1e9));
  const bool to_plan = fields.present("accuracy");
  const Rule accuracy = rule::between(1e-6, 0.5, "must be from 1e-6 to 0.5");
  const double tolerance = to_plan ? fields.number("accuracy", accuracy) : 0;
  fields.finish();
  if (planning == Planning::none)
    for (const char* key : {"accuracy", "planned_accuracy", "planned_error_bound"})
      scene.document.erase(key);
  if (!to_plan || planning == Planning::none) return scene;
  const Plan plan = make_plan(scene, tolerance);
  return parse_scene(plan.document, file);
}

void apply_setting(Json& document, const std::string& setting) {
  const auto equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    throw BadInput("--set " + setting + ": must be dotted.key=value");
  const std::string key = setting.substr(0, equals), text = setting.substr(equals + 1);
  Json value = Json::parse(text, nullptr, false);
  if (value.is_discarded()) value = text;
  Json* place = &document;
  for (std::size_t from = 0;;) {
    const auto dot = key.find('.', from);
    const std::string part = key.substr(from, dot == std::string::npos ? dot : dot - from);
    if (part.empty()) throw BadInput("--set " + setting + ": empty name in the dotted key");
    if (place->is_null()) *place = Json::object();
    if (!place->is_object())
      throw BadInput("--set " + setting + ": \"" + key.substr(0, from ? from - 1 : 0) +
                     "\" is not an object");
    place = &(*place)[part];
    if (dot == std::string::npos) break;
    from = dot + 1;
  }
  *place = value;
}

Scene load_scene(const std::string& name_or_file, const std::vector<std::string>& settings,
                 Planning planning) {
  const std::string file = kScenes.find(name_or_file);
  Json document = parse_json(read_text(file), file);
  for (const auto& setting : settings) apply_setting(document, setting);
  return parse_scene(document, settings.empty() ? file : file + " with --set", planning);
}

std::vector<std::string> shipped_scenes() {
  return kScenes.names();
}

void set_form(Json& document, Form form, const std::string& file) {
  if (!document.contains("laws") || !document["laws"].is_object()) return;
  std::string lacking;
  for (auto& [name, law] : document["laws"].items()) {
    if (!law.is_object()) continue;
    if (form == Form::printed && (name == "drag" || name == "meniscus")) lacking += " " + name;
    law["form"] = form == Form::printed ? "printed" : "corrected";
  }
  if (!lacking.empty()) throw BadInput(file + ": laws that the paper does not print:" + lacking);
}

}  // namespace ferrule
