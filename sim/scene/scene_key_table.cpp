#include <cmath>

#include "sim/base/units.hpp"
#include "sim/scene/scene_keys.hpp"

namespace ferrule {
// Of its own, as the names of its functions are short.
namespace scene_rows {
namespace {

using rule::between;
using rule::not_negative;
using rule::positive;

constexpr double kFarthest = 1e6;  // of a start [um]
constexpr Chance kSameInAllTrials = {.may = false};
constexpr Chance kWithParticle = {.shared = "laws.particle"};  // draw_particle draws all of it

void put(double& place, double x) {
  place = x;
}
void put(std::optional<double>& place, double x) {
  place = x;
}

// Where it is kept, as members of members: of the scene, of what it states of its world.
template <auto... path>
void in(Scene& scene, double x, std::size_t) {
  put((scene.*....*path), x);
}
template <auto... path>
void in_world(Scene& scene, double x, std::size_t) {
  put((scene.parameters.*....*path), x);
}
template <auto member>
constexpr auto fibre = in_world<&WorldParameters::fibre, member>;
template <auto member>
constexpr auto bore = in_world<&WorldParameters::ferrule, member>;
template <auto member>
constexpr auto numerics = in_world<&WorldParameters::numerics, member>;

// In one of two coordinates.
template <int coordinate, auto... path>
void along(Scene& scene, double x, std::size_t) {
  (scene.*....*path)[coordinate] = x;
}

template <auto member>
void lead_in(Scene& scene, double x, std::size_t) {
  if (scene.parameters.ferrule.lead_in) (*scene.parameters.ferrule.lead_in).*member = x;
}

template <class Form, class Has>
void put_if(Form& form, double Has::*member, double x) {
  if constexpr (std::is_base_of_v<Has, Form>) form.*member = x;
}
// Where the law, or the holder, is of a form that has one of these members.
template <auto... member, class... Forms>
void put_in_form(std::variant<Forms...>& forms, double x) {
  std::visit([x](auto& form) { (put_if(form, member, x), ...); }, forms);
}
template <auto... member, class Law>
void put_in_form(std::optional<Law>& law, double x) {
  if (law) (put_if(*law, member, x), ...);
}
template <auto which, auto... member>
void law(Scene& scene, double x, std::size_t) {
  put_in_form<member...>(scene.parameters.laws.*which, x);
}
template <auto member>
void holder(Scene& scene, double x, std::size_t) {
  put_in_form<member>(scene.parameters.holder, x);
}

void keep_quadrature(Scene& scene, double order, std::size_t) {
  scene.parameters.numerics.quadrature = Quadrature::gauss_legendre(static_cast<int>(order));
}

void keep_lateral_mean(Scene& scene, double x, std::size_t element) {
  if (element > 1) return;
  const auto i = static_cast<Eigen::Index>(element);
  scene.start.lateral_mean[i] = x;
  if (!states(scene, i == 0 ? "start.y_um" : "start.z_um")) scene.start.lateral[i] = x;
}

template <int coordinate>
void keep_vision(Scene& scene, double x, std::size_t) {
  if (!scene.start.vision) scene.start.vision = Vector2d::Zero();
  (*scene.start.vision)[coordinate] = x;
}

// The first of a list is that of `joint`; graded_joint knows the others.
template <auto member>
void first(Scene& scene, double x, std::size_t element) {
  if (element == 0) put(scene.joint.*member, x);
}

std::optional<Distribution> roll(const Scene& s) {
  const FibreParameters& f = s.parameters.fibre;
  if (!f.curl_radius_m && !f.cleave_deg) return std::nullopt;
  return Distribution::between(0, 360);
}
std::optional<Distribution> cleave_direction(const Scene& s) {
  if (!s.parameters.fibre.cleave_deg) return std::nullopt;
  return Distribution::between(0, 360);
}
std::optional<Distribution> ovality_direction(const Scene& s) {
  if (!s.parameters.ferrule.ovality_um) return std::nullopt;
  return Distribution::between(0, 180);
}

// Normal, in the unit of the file; empty where it does not vary.
std::optional<Distribution> scatter(double mean, double sd) {
  if (!(sd > 0)) return std::nullopt;
  return Distribution::about(mean, sd);
}
template <int coordinate>
std::optional<Distribution> lateral(const Scene& s) {
  return scatter(s.start.lateral_mean[coordinate] / micro, s.start.lateral_sd / micro);
}
std::optional<Distribution> tilt(const Scene& s) {
  return scatter(0, s.start.tilt_sd / milli);
}
std::optional<Distribution> vision(const Scene& s) {
  return scatter(0, s.start.vision_sd / micro);
}
std::optional<Distribution> entrance(const Scene& s) {
  return scatter(0, 1e6 * s.sensor.entrance_sd);
}
// What fibre and ferrule are off, together.
std::optional<Distribution> core(const Scene& s) {
  return scatter(
      0, 1e6 * std::sqrt(s.joint.core_sd * s.joint.core_sd + s.joint.bore_sd * s.joint.bore_sd));
}

Chance or_drawn(std::optional<Distribution> (*unless_stated)(const Scene&),
                const char* shared = "") {
  return {true, unless_stated, shared};
}

Rule turn() {
  return between(-360, 360, "must be from -360 to 360");
}
Rule sideways() {
  return between(-kFarthest, kFarthest, "must be from -1e6 to 1e6");
}
Rule below_90_degrees() {
  Rule angle = between(0, 90, "must be at least 0 and below 90 degrees");
  angle.high_open = true;
  return angle;
}
Rule trial_time() {
  Rule time = between(0, 3600, "must be positive and at most 3600");
  time.low_open = true;
  return time;
}
Rule whole(int low, int high) {
  Rule number =
      between(low, high,
              "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high));
  number.whole = true;
  return number;
}

using F = FibreParameters;
using B = FerruleParameters;
using S = ForceSensorModel;
using H = HandErrors;
using R = ScalingRanges;
constexpr auto start = &Scene::start;
constexpr auto sensor = &Scene::sensor;
constexpr auto hand = &Scene::hand;
constexpr auto limits = &Scene::limits;
constexpr auto joint = &Scene::joint;
constexpr auto scaling = &Scene::scaling;

const std::vector<SceneKey> kRows = {
    {"name", ""},
    {"about", "Where the numbers come from and what is assumed."},
    {"extends",
     "The scene that this one changes: the name of one that ships, or a file. What is stated "
     "here takes its place, key by key; a law, the lead-in and the holder are stated whole."},
    {"fibre", ""},
    {"fibre.diameter_um", "", positive(1, 1e5), 1, fibre<&F::diameter_um>},
    {"fibre.density_kg_m3", "", positive(1, 1e5), 1, fibre<&F::density_kg_m3>},
    {"fibre.young_GPa", "", positive(1e-3, 1e4), 1, fibre<&F::young_GPa>},
    {"fibre.poisson", "", between(-1, 0.5, "must be from -1 to 0.5"), 1, fibre<&F::poisson>},
    {"fibre.shear_GPa", "", positive(1e-6, 1e4), 1, fibre<&F::shear_GPa>},
    {"fibre.manipulated_length_mm", "Length of fibre that the holder carries.", positive(1e-3, 1e4),
     1, fibre<&F::manipulated_length_mm>},
    {"fibre.curl_radius_m",
     "Radius of the fibre's natural curvature: its free end lies aside and tilts, in the "
     "direction of its roll angle. At least ten times the free length. Missing: straight.",
     positive(1e-2, 1e9), 1, fibre<&F::curl_radius_m>},
    {"fibre.roll_deg",
     "How the fibre lies in the gripper, turned about its axis from y to z. Missing: drawn for "
     "each trial.",
     turn(), 1, fibre<&F::roll_deg>, or_drawn(roll)},
    {"fibre.cleave_deg",
     "Angle of the end's face to the fibre's cross-section. Stated, and be it 0, the end rests "
     "on the front face where it is lowest; missing, as if it were upright.",
     between(0, 10, "must be from 0 to 10"), 1, fibre<&F::cleave_deg>},
    {"fibre.edge_um",
     "Radius that the rim of the fibre's end is rounded to, at most a quarter of its diameter. "
     "The contact radius of adhesion and wall follows from it. Missing: sharp.",
     positive(kSharpestEdge, 1e4), 1, fibre<&F::edge_um>},
    {"fibre.cleave_direction_deg",
     "Where the leading point of a cleaved end's rim lies, from the roll angle. Missing: drawn "
     "for each trial.",
     turn(), 1, fibre<&F::cleave_direction_deg>, or_drawn(cleave_direction)},
    {"ferrule", ""},
    {"ferrule.bore_diameter_um", "", positive(1, 1e5), 1, bore<&B::bore_diameter_um>},
    {"ferrule.length_mm", "", positive(1e-3, 1e4), 1, bore<&B::length_mm>},
    {"ferrule.ovality_um",
     "Largest less smallest diameter of an oval bore, at most 0.6 of what it is wider than the "
     "fibre. Missing: round.",
     not_negative(1e5), 1, bore<&B::ovality_um>},
    {"ferrule.ovality_direction_deg",
     "Where the largest diameter lies, from y to z. Missing: drawn for each trial.", turn(), 1,
     bore<&B::ovality_direction_deg>, or_drawn(ovality_direction)},
    {"ferrule.young_GPa", "", positive(1e-3, 1e4), 1, bore<&B::young_GPa>},
    {"ferrule.poisson", "", between(-1, 0.5, "must be from -1 to 0.5"), 1, bore<&B::poisson>},
    {"ferrule.shear_GPa", "", positive(1e-6, 1e4), 1, bore<&B::shear_GPa>},
    {"ferrule.lead_in",
     "The cone at the mouth: full angle, and diameter where it meets the front face. null: a "
     "sharp edge."},
    {"ferrule.lead_in.angle_deg", "", between(1, 179, "must be from 1 to 179 degrees (full angle)"),
     1, lead_in<&LeadIn::angle_deg>},
    {"ferrule.lead_in.diameter_um", "", positive(1, 1e5), 1, lead_in<&LeadIn::diameter_um>},
    {"roughness_nm", "Smallest distance of the mean surfaces, for the corrected surface laws.",
     not_negative(1e5), 1, in<&Scene::parameters, &WorldParameters::roughness_nm>},
    {"laws", "A law that is not there, or null, is not modelled."},
    {"laws.van_der_waals", ""},
    {"laws.van_der_waals.form", ""},
    {"laws.van_der_waals.hamaker_J", "", positive(1e-40, 1e-17), 1,
     law<&Laws::van_der_waals, &VanDerWaals::hamaker, &printed::VanDerWaals::hamaker>},
    {"laws.electrostatic", ""},
    {"laws.electrostatic.form", ""},
    {"laws.electrostatic.voltage_V", "", not_negative(1e5), 1,
     law<&Laws::electrostatic, &Electrostatic::voltage, &printed::Electrostatic::voltage>},
    {"laws.gravity", ""},
    {"laws.gravity.form", ""},
    {"laws.capillary", ""},
    {"laws.capillary.form", ""},
    {"laws.capillary.surface_tension_N_m", "", positive(1e-30, 3), 1,
     law<&Laws::capillary, &Capillary::surface_tension, &printed::Capillary::surface_tension>},
    {"laws.capillary.contact_angle_deg", "", below_90_degrees(), degree,
     law<&Laws::capillary, &Capillary::contact_angle, &printed::Capillary::contact_angle>},
    {"laws.capillary.film_nm", "", positive(1e-3, 1e6), nano,
     law<&Laws::capillary, &Capillary::film, &printed::Capillary::film>},
    {"laws.capillary.volume_per_length_m2",
     "Liquid per length of a bridge; needed by the corrected form.", positive(1e-20, 1e-6), 1,
     law<&Laws::capillary, &Capillary::volume>},
    {"laws.capillary.rupture_nm",
     "Gap at which a bridge ruptures, more than twice film_nm; needed by the corrected form.",
     positive(1e-3, 1e6), nano, law<&Laws::capillary, &Capillary::rupture>},
    {"laws.adhesion", ""},
    {"laws.adhesion.form", ""},
    {"laws.adhesion.work_of_adhesion_J_m2", "w = 2 gamma, the work, not the surface energy.",
     positive(1e-9, 1e3), 1,
     law<&Laws::adhesion, &Adhesion::work_of_adhesion, &printed::Adhesion::work_of_adhesion>},
    {"laws.adhesion.maugis_lambda", "The printed form: from 0.12 to 5.8.",
     between(0.01, 100, "must be from 0.01 to 100"), 1,
     law<&Laws::adhesion, &Adhesion::maugis_lambda, &printed::Adhesion::maugis_lambda>},
    {"laws.adhesion.m", "", between(1, 1e3, "must be at least 1, at most 1000"), 1,
     law<&Laws::adhesion, &printed::Adhesion::m>},
    {"laws.adhesion.radius_um", "R_s of the corrected form; the fibre's radius unless given.",
     positive(1e-3, 1e6), micro, law<&Laws::adhesion, &Adhesion::radius>},
    {"laws.friction", ""},
    {"laws.friction.form", ""},
    {"laws.friction.burgers_nm", "", positive(1e-6, 1e3), nano,
     law<&Laws::friction, &Friction::burgers>},
    {"laws.drag", "Liquid fills the gap."},
    {"laws.drag.form", ""},
    {"laws.drag.viscosity_Pa_s", "", positive(1e-30, 1e6), 1, law<&Laws::drag, &Drag::viscosity>},
    {"laws.meniscus", "Liquid ends in a meniscus at the mouth."},
    {"laws.meniscus.form", ""},
    {"laws.meniscus.surface_tension_N_m", "", positive(1e-30, 3), 1,
     law<&Laws::meniscus, &Meniscus::surface_tension>},
    {"laws.meniscus.contact_angle_deg", "", below_90_degrees(), degree,
     law<&Laws::meniscus, &Meniscus::contact_angle>},
    {"laws.flow",
     "Fluid ahead of the end: liquid or gas that it pushes out of an open or a blind bore."},
    {"laws.flow.form", ""},
    {"laws.flow.viscosity_Pa_s", "", positive(1e-30, 1e6), 1, law<&Laws::flow, &Flow::viscosity>},
    {"laws.flow.bore", "Blind: closed at its far end, ferrule.length_mm from the entrance."},
    {"laws.flow.fluid", ""},
    {"laws.flow.vapour_pressure_kPa", "Of a liquid, which cavitates below it.",
     between(0, 1e-3 * kAtmosphere, "must be from 0 to 101.325"), 1e3,
     law<&Laws::flow, &Flow::vapour_pressure>},
    {"laws.particle",
     "A hard bump on the wall of the bore, the highest one on the length that goes in: stated, "
     "or drawn per trial."},
    {"laws.particle.form", ""},
    {"laws.particle.number",
     "Of particles on the wall of the length that goes in, on average (Poisson).",
     between(0, 1000, "must be from 0 to 1000"), 1, law<&Laws::particle, &Particle::number>},
    {"laws.particle.median_um", "Of their heights, which are log-normal.", positive(1e-3, 100),
     micro, law<&Laws::particle, &Particle::median>},
    {"laws.particle.spread", "Standard deviation of the natural logarithm of the heights.",
     between(0, 3, "must be from 0 to 3"), 1, law<&Laws::particle, &Particle::spread>},
    {"laws.particle.height_um",
     "Drawn per trial unless stated, with at_um and direction_deg; 0: there is none.",
     between(0, 1e6 * kHighestParticle, "must be from 0 to 1000"), micro,
     law<&Laws::particle, &Particle::height>, kWithParticle},
    {"laws.particle.at_um", "Depth in the bore, so that all of it is within.", not_negative(1e7),
     micro, law<&Laws::particle, &Particle::depth>, kWithParticle},
    {"laws.particle.direction_deg", "From y to z.", turn(), degree,
     law<&Laws::particle, &Particle::direction>, kWithParticle},
    {"holder",
     "rigid_hand: a virtual coupling between the commanded pose and the fibre's end. "
     "elastic_fibre: a cantilever clamped in a gripper."},
    {"holder.type", ""},
    {"holder.stiffness_N_m", "", positive(1e-9, 1e9), 1, holder<&RigidHand::stiffness_N_m>},
    {"holder.tilt_stiffness_N_m_rad", "", positive(1e-15, 1e9), 1,
     holder<&RigidHand::tilt_stiffness_N_m_rad>},
    {"holder.free_length_mm", "", positive(1e-3, 1e4), 1, holder<&ElasticFibre::free_length_mm>},
    {"holder.gripper_stiffness_N_m", "", positive(1e-6, 1e9), 1,
     holder<&ElasticFibre::gripper_stiffness_N_m>},
    {"holder.loss_factor",
     "Of the bending of the free fibre in its first mode, where inertia is modelled; 1/Q. "
     "Missing: 0.",
     between(0, 1, "must be from 0 to 1"), 1, holder<&ElasticFibre::loss_factor>},
    {"dynamics", "Whether inertia is modelled; quasi_static unless given."},
    {"integrator", "Of inertia: first or second order; backward_euler unless given."},
    {"quadrature",
     "Gauss-Legendre nodes, along the insertion, of corrected surface forces that are not taken "
     "in closed form; 5 unless given.",
     whole(1, kMostNodes), 1, keep_quadrature},
    {"tilted_axes",
     "Corrected van der Waals and electrostatic forces between tilted axes: in closed form "
     "unless given."},
    {"step_s", "Longest step in time; longer ones are divided.",
     between(1e-7, 1, "must be from 1e-7 to 1"), 1, numerics<&Numerics::longest_step>,
     kSameInAllTrials},
    {"event_travel_nm",
     "Steps in which a contact or bridge opens or closes, a contact turns over an edge, or the "
     "fibre snaps, are divided until the hand travels no more than this in them; 0.1 unless "
     "given, and none are in scenes with printed surface laws or adhesion.",
     positive(1e-6, 1e9), nano, numerics<&Numerics::event_travel>},
    {"start",
     "Where the fibre's end rests at the start: distance outside the bore; sideways [y, z] and "
     "tilts normally distributed, cut at three standard deviations."},
    {"start.distance_um", "", not_negative(kFarthest), micro, in<start, &InsertionStart::distance>},
    {"start.lateral_mean_um", "", sideways(), micro, keep_lateral_mean},
    {"start.lateral_sd_um", "", not_negative(kFarthest), micro,
     in<start, &InsertionStart::lateral_sd>},
    {"start.tilt_sd_mrad", "", between(0, 100, "must be from 0 to 100"), milli,
     in<start, &InsertionStart::tilt_sd>},
    {"start.vision_sd_um",
     "How well a simulated operator sees the bore's axis, to which he steers before the "
     "entrance; absent: he keeps the line that he starts on.",
     not_negative(kFarthest), micro, in<start, &InsertionStart::vision_sd>},
    {"start.y_um",
     "Where the end of a straight fibre starts, along y: drawn per trial about lateral_mean_um "
     "by lateral_sd_um unless given.",
     sideways(), micro, along<0, start, &InsertionStart::lateral>,
     or_drawn(lateral<0>, "start.lateral_sd_um")},
    {"start.z_um", "The same along z.", sideways(), micro,
     along<1, start, &InsertionStart::lateral>, or_drawn(lateral<1>, "start.lateral_sd_um")},
    {"start.tilt_y_mrad",
     "How it is tilted towards y: drawn per trial by tilt_sd_mrad unless given.",
     between(-300, 300, "must be from -300 to 300"), milli, along<0, start, &InsertionStart::tilt>,
     or_drawn(tilt, "start.tilt_sd_mrad")},
    {"start.tilt_z_mrad", "The same towards z.", between(-300, 300, "must be from -300 to 300"),
     milli, along<1, start, &InsertionStart::tilt>, or_drawn(tilt, "start.tilt_sd_mrad")},
    {"start.vision_y_um",
     "Where a simulated operator sees the bore's axis, along y: drawn per trial by vision_sd_um "
     "unless given.",
     sideways(), micro, keep_vision<0>, or_drawn(vision, "start.vision_sd_um")},
    {"start.vision_z_um", "The same along z.", sideways(), micro, keep_vision<1>,
     or_drawn(vision, "start.vision_sd_um")},
    {"tolerance",
     "As scenes before 0.9.0 draw diameters: the fibre's normal about fibre.diameter_um and cut "
     "at 3 standard deviations, or uniform between two; the bore's uniform between two.",
     {},
     1,
     nullptr,
     kSameInAllTrials},
    {"tolerance.fibre_diameter_um", "", positive(1, 1e5), 1, nullptr, kSameInAllTrials},
    {"tolerance.fibre_diameter_sd_um", "", not_negative(1e3), 1, nullptr, kSameInAllTrials},
    {"tolerance.bore_diameter_um", "", positive(1, 1e5), 1, nullptr, kSameInAllTrials},
    {"sensor",
     "The force sensor at the holder, per component: standard deviations of noise and of bias, "
     "bandwidth, resolution; the arm at which a moment is measured as a force. What is missing "
     "is ideal."},
    {"sensor.noise_uN", "", not_negative(1e9), micro, in<sensor, &S::noise>},
    {"sensor.bias_uN", "", not_negative(1e9), micro, in<sensor, &S::bias>},
    {"sensor.bandwidth_Hz", "", positive(1e-3, 1e9), 1, in<sensor, &S::bandwidth>},
    {"sensor.resolution_uN", "", not_negative(1e9), micro, in<sensor, &S::resolution>},
    {"sensor.moment_arm_mm", "", positive(1e-6, 1e6), milli, in<sensor, &S::arm>},
    {"sensor.bias_walk_uN_sqrt_s", "Standard deviation of the bias' random walk after one second.",
     not_negative(1e9), micro, in<sensor, &S::bias_walk>},
    {"sensor.gain_error", "Standard deviation of the relative gain of each component.",
     not_negative(1), 1, in<sensor, &S::gain_error>},
    {"sensor.cross_talk",
     "Standard deviation of what a component reads of each other one, relative.", not_negative(1),
     1, in<sensor, &S::cross_talk>},
    {"sensor.temperature_drift_uN_K",
     "Standard deviation of each component's drift with temperature.", not_negative(1e9), micro,
     in<sensor, &S::drift>},
    {"sensor.temperature_rate_K_s", "Standard deviation of the rate at which a trial warms up.",
     not_negative(1e3), 1, in<sensor, &S::temperature_rate>},
    {"sensor.vibration_uN", "Root mean square of what vibration adds to each component.",
     not_negative(1e9), micro, in<sensor, &S::vibration>},
    {"sensor.vibration_Hz", "Its frequency; 50 unless given.", positive(1e-3, 1e9), 1,
     in<sensor, &S::vibration_frequency>},
    {"sensor.tare_s",
     "Who reads it tares in free air, by a mean of that time constant; 0: by the first reading "
     "alone.",
     not_negative(1e3), 1, in<sensor, &S::tare_time>},
    {"sensor.dead_band_uN", "Who reads it takes a smaller force, relative to the tare, for none.",
     not_negative(1e9), micro, in<sensor, &S::dead_band>},
    {"sensor.entrance_sd_um",
     "Standard deviation of where the bore's entrance is taken to be, along the bore: operators, "
     "controllers and the tare go by that. What counts as inserted does not.",
     not_negative(1e6), micro, in<sensor, &S::entrance_sd>},
    {"sensor.entrance_error_um",
     "Where it is taken to be, out of the bore positive. Missing: drawn for each trial.",
     between(-1e7, 1e7, "must be from -1e7 to 1e7"), micro, in<sensor, &S::entrance_error>,
     or_drawn(entrance)},
    {"hand",
     "How the holder does not move quite as the hand means it to, of whoever inserts: a person, "
     "an operator, a controller. Off unless stated; mostly drawn for each trial."},
    {"hand.gain", "The holder's motion over what is commanded; 1 unless given.",
     between(0.01, 100, "must be from 0.01 to 100"), 1, in<hand, &H::gain>},
    {"hand.delay_ms", "The holder moves so much later.", not_negative(1e3), milli,
     in<hand, &H::delay>},
    {"hand.smoothing_ms", "Time constant of a first-order lag of the holder's motion.",
     not_negative(1e5), milli, in<hand, &H::smoothing>},
    {"hand.dead_zone_um_s",
     "Slower commands, at the tip's scale, do not move the holder; turns do.", not_negative(1e9),
     micro, in<hand, &H::dead_zone>},
    {"hand.grasp_y_um",
     "How far the fibre lies beside where it should in the gripper: added to its start.",
     sideways(), micro, along<0, hand, &H::grasp>},
    {"hand.grasp_z_um", "As grasp_y_um.", sideways(), micro, along<1, hand, &H::grasp>},
    {"hand.grasp_tilt_y_mrad", "How far the fibre is turned in the gripper: added to its start.",
     between(-100, 100, "must be from -100 to 100"), milli, along<0, hand, &H::grasp_tilt>},
    {"hand.grasp_tilt_z_mrad", "As grasp_tilt_y_mrad.",
     between(-100, 100, "must be from -100 to 100"), milli, along<1, hand, &H::grasp_tilt>},
    {"limits",
     "Largest force at the holder (weight apart), largest commanded speed of the tip, longest "
     "trial."},
    {"limits.force_uN", "", positive(1e-6, 1e12), micro, in<limits, &Limits::force>},
    {"limits.speed_um_s", "", positive(1e-6, 1e9), micro, in<limits, &Limits::speed>},
    {"limits.time_s", "", trial_time(), 1, in<limits, &Limits::time>},
    {"limits.proof_stress_GPa", "", positive(1e-9, 1e6), giga, in<limits, &Limits::proof_stress>},
    {"tangent",
     "Smooth intervals are followed along the tangent, without solving every step, to about "
     "these errors; absent: 1e-5 of the clearance and of limits.force_uN. Quasi-static scenes "
     "without flow."},
    {"tangent.tip_nm", "Of the end; 0: every step is solved.", not_negative(1e6), nano,
     numerics<&Numerics::extrapolation_tip>},
    {"tangent.force_uN", "At the holder; 0: every step is solved.", not_negative(1e6), micro,
     numerics<&Numerics::extrapolation_force>},
    {"success", "Inserted length that counts."},
    {"success.depth_um", "", positive(1e-6, 1e7), micro, in<&Scene::success, &Success::depth>},
    {"success.loss_dB",
     "Most that the joint with an ideal partner may lose there. A fibre that loses more ends as "
     "high_loss. Missing: any.",
     positive(1e-9, 1e6), 1, in<&Scene::success, &Success::loss_dB>},
    {"joint",
     "The joint of the fibre with that of another ferrule: what its predicted loss depends on."},
    {"joint.wavelength_nm",
     "Of the light, in vacuum, or a list: a grade holds for all, the loss with an ideal partner "
     "is at the first. 1550 unless given; grades then 1310 and 1550.",
     positive(100, 1e5), nano, first<&Joint::wavelength>},
    {"joint.index", "Refractive, of the fibres and of what fills the gap; 1.4682 unless given.",
     between(1, 5, "must be from 1 to 5"), 1, in<joint, &Joint::index>},
    {"joint.mode_field_diameter_um",
     "Where the field is 1/e of that on the axis, or a list, one for each wavelength; 10.4 "
     "unless given; grades then 9.2 at 1310 nm, 10.4 at 1550 nm, others on that line.",
     positive(0.1, 1e4), 0.5 * micro, first<&Joint::mode_radius>},
    {"joint.partner_mode_field_diameter_um",
     "That of the fibre on the other side, or a list, one for each wavelength; the same unless "
     "given.",
     positive(0.1, 1e4), 0.5 * micro, first<&Joint::partner_mode_radius>},
    {"joint.gap_um", "Between the ends, filled with the fibres' index; 0 unless given.",
     not_negative(1e6), micro, in<joint, &Joint::gap>},
    {"joint.core_concentricity_sd_um",
     "Standard deviation, in y and in z, of the core's axis from that of its fibre; 0 unless "
     "given, grades then 0.2.",
     not_negative(1e3), micro, in<joint, &Joint::core_sd>},
    {"joint.bore_concentricity_sd_um",
     "Standard deviation, in y and in z, of the bore's axis from that of its ferrule; 0 unless "
     "given, grades then 0.3.",
     not_negative(1e3), micro, in<joint, &Joint::bore_sd>},
    {"joint.offset_y_um",
     "Of the core from the ferrule's axis, were the fibre in the middle of the bore: drawn per "
     "trial unless given.",
     between(-1e5, 1e5, "must be from -1e5 to 1e5"), micro, along<0, joint, &Joint::offset>,
     or_drawn(core)},
    {"joint.offset_z_um", "The same along z.", between(-1e5, 1e5, "must be from -1e5 to 1e5"),
     micro, along<1, joint, &Joint::offset>, or_drawn(core)},
    {"scaling",
     "Ranges of the hand and of the tip, equations (14) and (15): their ratios scale motion and "
     "force."},
    {"scaling.hand_range_mm", "", positive(1e-6, 1e6), milli, in<scaling, &R::hand_range>},
    {"scaling.tip_range_um", "", positive(1e-6, 1e6), micro, in<scaling, &R::tip_range>},
    {"scaling.hand_force_N", "", positive(1e-9, 1e6), 1, in<scaling, &R::hand_force>},
    {"scaling.tip_force_uN", "", positive(1e-9, 1e12), micro, in<scaling, &R::tip_force>},
    {"cue",
     "Whether the operator's window shows an arrow that says which way to correct sideways, and "
     "by how much. It changes nothing else."},
    {"accuracy", "Plan terms, dynamics and step for this tolerance (ferrule plan).",
     between(1e-6, 0.5, "must be from 1e-6 to 0.5"), 1, in<&Scene::accuracy>, kSameInAllTrials},
    {"planned_accuracy", "Written by the program: the tolerance this scene was planned for.",
     positive(1e-6, 0.5), 1, nullptr, kSameInAllTrials},
    {"planned_error_bound", "Written by the program: the error bound of that plan.",
     not_negative(1e9), 1, nullptr, kSameInAllTrials},
};

}  // namespace
}  // namespace scene_rows

const std::vector<SceneKey>& scene_keys() {
  return scene_rows::kRows;
}

}  // namespace ferrule
