#include "bench/random_scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/error.hpp"
#include "sim/base/random.hpp"
#include "sim/laws/particle.hpp"

namespace ferrule {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;  // [rad]
// Share of the numbers that are drawn over the schema's whole range.
constexpr double kWhole = 0.05;
constexpr double kJump = 1e-3;  // time in which a jump is made where periods are finer [s]

class Chance {
 public:
  Chance(std::uint64_t seed, std::uint64_t k, Draw draw) : random_(seed, k, draw) {}
  double between(double low, double high) { return low + (high - low) * random_.uniform(); }
  double decades(double low, double high) { return low * std::pow(high / low, random_.uniform()); }
  bool with(double p) { return random_.uniform() < p; }
  double around(double a) { return between(-a, a); }
  // A number that is usually from `low` to `high`, and from `least` to `most` in the schema.
  double number(double low, double high, double least, double most) {
    return with(kWhole) ? decades(least, most) : decades(low, high);
  }
  double normal() { return random_.normal(); }
  const char* form() { return with(0.35) ? "printed" : "corrected"; }

 private:
  RandomStream random_;
};

Json solid(Chance& chance) {
  return {{"young_GPa", chance.number(5, 400, 1e-3, 1e4)},
          {"poisson", chance.between(0, 0.45)},
          {"shear_GPa", chance.number(0.5, 150, 1e-6, 1e4)}};
}

Json draw_laws(Chance& chance) {
  Json laws = Json::object();
  if (chance.with(0.6))
    laws["van_der_waals"] = {{"form", chance.form()},
                             {"hamaker_J", chance.number(1e-21, 1e-18, 1e-40, 1e-17)}};
  if (chance.with(0.6))
    laws["electrostatic"] = {{"form", chance.form()},
                             {"voltage_V", chance.number(1e-3, 30, 1e-12, 1e5)}};
  if (chance.with(0.6)) laws["gravity"] = {{"form", chance.form()}};
  if (chance.with(0.25)) {
    const double film = chance.number(5, 300, 1e-3, 1e6);
    laws["capillary"] = {{"form", chance.form()},
                         {"surface_tension_N_m", chance.number(0.01, 0.08, 1e-30, 3)},
                         {"contact_angle_deg", chance.between(0, 85)},
                         {"film_nm", film},
                         {"volume_per_length_m2", chance.number(1e-15, 1e-11, 1e-20, 1e-6)},
                         {"rupture_nm", film * chance.between(2.1, 6)}};
  }
  if (chance.with(0.6)) {
    const bool printed = chance.with(0.35);
    laws["adhesion"] = {
        {"form", printed ? "printed" : "corrected"},
        {"work_of_adhesion_J_m2", chance.number(1e-3, 0.4, 1e-9, 1e3)},
        {"maugis_lambda", printed ? chance.between(0.13, 5.7) : chance.decades(0.01, 100)},
        {"m", chance.between(1.01, 2)}};
  }
  if (chance.with(0.65))
    laws["friction"] = {{"form", chance.form()}, {"burgers_nm", chance.number(0.05, 1, 1e-6, 1e3)}};
  if (chance.with(0.2))
    laws["drag"] = {{"form", "corrected"}, {"viscosity_Pa_s", chance.number(1e-3, 10, 1e-30, 1e6)}};
  if (chance.with(0.3))
    laws["meniscus"] = {{"form", "corrected"},
                        {"surface_tension_N_m", chance.number(0.01, 0.08, 1e-30, 3)},
                        {"contact_angle_deg", chance.between(0, 85)}};
  return laws;
}

Json draw_document(Chance& chance) {
  Json d = load_scene("paper").document();
  d["name"] = "random";
  const double fibre = chance.number(50, 400, 1, 1e4);
  const double clearance = std::min(chance.number(0.02, 50, 1e-3, 1e3), 10 * fibre);
  d["fibre"] = solid(chance);
  d["fibre"]["diameter_um"] = fibre;
  d["fibre"]["density_kg_m3"] = chance.number(1e3, 8e3, 1, 1e5);
  d["fibre"]["manipulated_length_mm"] = chance.number(3, 100, 1e-3, 1e4);
  d["ferrule"] = solid(chance);
  const double bore = fibre + 2 * clearance;
  d["ferrule"]["bore_diameter_um"] = bore;
  d["ferrule"]["length_mm"] = chance.number(2, 20, 0.1, 1e4);
  d["ferrule"]["lead_in"] = nullptr;
  if (chance.with(0.7))
    d["ferrule"]["lead_in"] = {{"angle_deg", chance.between(10, 150)},
                               {"diameter_um", bore * chance.between(1.05, 3)}};
  d["roughness_nm"] = chance.with(0.15) ? 0 : chance.number(0.3, 50, 1e-3, 1e5);
  d["laws"] = draw_laws(chance);
  if (chance.with(0.5))
    d["holder"] = {{"type", "elastic_fibre"},
                   {"free_length_mm", chance.number(2, 20, 0.5, 1e3)},
                   {"gripper_stiffness_N_m", chance.number(10, 1e4, 1, 1e9)}};
  else
    d["holder"] = {{"type", "rigid_hand"},
                   {"stiffness_N_m", chance.number(0.05, 50, 1e-4, 1e9)},
                   {"tilt_stiffness_N_m_rad", chance.number(1e-7, 1e-2, 1e-9, 1e9)}};
  if (chance.with(0.1)) {
    d["dynamics"] = "inertial";
    d["integrator"] = chance.with(0.5) ? "bdf2" : "backward_euler";
  }
  if (chance.with(0.1)) d["tilted_axes"] = "quadrature";
  const double depth =
      std::min(chance.number(2, 100, 0.1, 1e3), 500 * d["ferrule"]["length_mm"].get<double>());
  d["start"] = {{"distance_um", chance.decades(1, 30)},
                {"lateral_mean_um", {0, 0}},
                {"lateral_sd_um", chance.decades(0.2, 5) * clearance},
                {"tilt_sd_mrad", chance.decades(0.1, 5)}};
  d["limits"] = {{"force_uN", chance.number(2, 200, 1e-3, 1e6)},
                 {"speed_um_s", chance.number(3, 100, 0.1, 1e4)},
                 {"time_s", 60}};
  d["success"] = {{"depth_um", depth}};
  return d;
}

// Up to three clearances high.
void add_particle(Json& d, Chance& chance) {
  const double wider =
      d["ferrule"]["bore_diameter_um"].get<double>() - d["fibre"]["diameter_um"].get<double>();
  const double height = std::min(1e3, chance.decades(0.05, 1.5) * wider);
  const Json& cone = d["ferrule"]["lead_in"];
  const double tangent =
      cone.is_null() ? 0 : std::tan(0.25 * kTurn / 180 * cone["angle_deg"].get<double>());
  const double least = 1.001 * shallowest(height, d["fibre"].value("edge_um", 0.0), tangent);
  d["laws"]["particle"] = {
      {"form", "corrected"},
      {"height_um", height},
      {"at_um", least + d["success"]["depth_um"].get<double>() * chance.between(0, 1)},
      {"direction_deg", chance.between(0, 360)}};
}

// What real parts have: curl, an oval bore, a fluid ahead of the end, a cleaved or rounded end, a
// particle. Its own stream of chance, so that the scenes are the same but for it.
void add_real_parts(Json& d, Chance& chance) {
  if (chance.with(0.25)) {
    const Json& h = d["holder"];
    const double free = h.contains("free_length_mm")
                            ? h["free_length_mm"].get<double>()
                            : d["fibre"]["manipulated_length_mm"].get<double>();
    d["fibre"]["curl_radius_m"] = std::max(chance.number(1, 100, 1e-2, 1e6), 0.011 * free);
  }
  if (chance.with(0.25)) {
    const double wider =
        d["ferrule"]["bore_diameter_um"].get<double>() - d["fibre"]["diameter_um"].get<double>();
    d["ferrule"]["ovality_um"] = 0.59 * wider * chance.between(0, 1);
    d["ferrule"]["ovality_direction_deg"] = chance.between(0, 180);
  }
  if (chance.with(0.25)) {
    const bool gas = chance.with(0.5);
    d["laws"]["flow"] = {{"form", "corrected"},
                         {"bore", chance.with(0.6) ? "blind" : "open"},
                         {"fluid", gas ? "gas" : "liquid"},
                         {"viscosity_Pa_s", gas ? chance.number(1e-6, 1e-4, 1e-30, 1e6)
                                                : chance.number(1e-3, 10, 1e-30, 1e6)}};
    if (!gas) d["laws"]["flow"]["vapour_pressure_kPa"] = chance.between(0, 100);
  }
  if (chance.with(0.2)) d["sensor"]["entrance_sd_um"] = chance.number(1, 20, 1e-3, 1e3);
  if (chance.with(0.25)) {
    d["fibre"]["cleave_deg"] = chance.between(0, 2);
    d["fibre"]["cleave_direction_deg"] = chance.between(0, 360);
  }
  if (chance.with(0.25))
    d["fibre"]["edge_um"] =
        std::min(chance.number(0.1, 10, 1e-3, 100), 0.24 * d["fibre"]["diameter_um"].get<double>());
  if (chance.with(0.25)) add_particle(d, chance);
}

// From 0 to 1, at rest at both ends.
double smooth(double p) {
  p = std::clamp(p, 0.0, 1.0);
  return p * p * (3 - 2 * p);
}

double start_distance(const Scene& scene, const State& start) {
  return std::max(start.tip[0], scene.world.profile.lead_in_length);
}

// In and out on a smooth motion, to the axis on the way in, while it wanders.
class Wandering {
 public:
  Wandering(const Scene& scene, const State& start, Chance& chance, double aside, double longest)
      : start_(start.command), sag_(scene.world.holder.sag), tip_(start.tip) {
    depth_ = std::min(scene.success.depth, 0.5 * scene.world.profile.length);
    way_ = start_distance(scene, start) + depth_;
    const double c = scene.world.annulus.clearance();
    for (double& a : aside_) a = chance.around(aside);
    const double lean = std::min({2 * c / depth_, 3 * scene.start.tilt_sd + 1e-6, 0.02});
    for (double& t : tilt_) t = chance.around(lean);
    for (double& p : phase_) p = chance.between(0, kTurn);
    duration_ =
        1e-3 * std::ceil(1e3 * std::min(longest, 2 * 1.5 * way_ / (0.7 * scene.limits.speed)));
  }
  double duration() const { return duration_; }
  Pose at(double time) const {
    const double p = time / duration_, in = smooth(2 * p) - smooth(2 * p - 1);
    const double there = smooth(4 * p) - smooth(4 * p - 3);  // near the axis, and wandering
    Pose tip = (1 - there) * tip_;
    tip[0] = tip_[0] - way_ * in;
    for (int i = 0; i < 2; ++i) {
      const double wave = std::sin(kTurn * (5 + i) * 0.37 * p + phase_[i]);
      const double swing = std::sin(kTurn * (3 + i) * 0.41 * p + phase_[2 + i]);
      tip[1 + i] += there * aside_[i] * wave;
      tip[3 + i] += there * tilt_[i] * swing;
    }
    if (time >= duration_) return start_;
    return tip - sag_;
  }

 private:
  Pose start_, sag_, tip_;
  double depth_, way_, duration_;
  std::array<double, 2> aside_, tilt_;
  std::array<double, 4> phase_;
};

// Far out, away from everything.
double far_out(const Scene& scene, const State& start) {
  return start.command[0] + scene.world.profile.lead_in_length + 100e-6;
}

constexpr double kSteepest = 0.02;  // tilts are small slopes [rad]

std::vector<Pose> draw_jumps(const Scene& scene, const State& start, Chance& chance) {
  std::vector<Pose> hand = {start.command};
  const double c = scene.world.annulus.clearance();
  const double way = start_distance(scene, start) + scene.success.depth;
  const double lever = scene.world.annulus.fibre_radius;
  const auto sweep = [&](const Pose& to, int steps) {
    const Pose from = hand.back();
    for (int n = 1; n <= steps; ++n) hand.push_back(from + (to - from) * n / steps);
  };
  for (int part = 0; part < 12; ++part) {
    Pose goal = start.command;
    goal[0] -= way * chance.between(-0.1, 1.2);
    for (int i : {1, 2})
      goal[i] = c * chance.decades(0.1, 300) * chance.around(1) - scene.world.holder.sag[i];
    for (int i : {3, 4}) goal[i] = chance.around(std::min(kSteepest, 10 * c / lever));
    sweep(goal, static_cast<int>(chance.decades(1, 300)));
    for (int n = 0; n < 5; ++n) {
      Pose near = hand.back();
      const double reach = chance.decades(1e-9, 30 * c + 2e-9);
      for (int i = 0; i < 3; ++i) near[i] += reach * chance.normal();
      for (int i : {3, 4}) near[i] += std::min(kSteepest, reach / lever) * chance.normal();
      hand.push_back(near);
      if (chance.with(0.3)) hand.push_back(near);  // a stall
    }
  }
  Pose out = hand.back();
  out[0] = far_out(scene, start);
  sweep(out, static_cast<int>(chance.decades(1, 1000)));
  sweep(start.command, static_cast<int>(chance.decades(1, 1000)));
  return hand;
}

std::vector<Pose> in_parts(const std::vector<Pose>& hand, long parts) {
  std::vector<Pose> fine = {hand.front()};
  for (std::size_t n = 1; n < hand.size(); ++n)
    for (long part = 1; part <= parts; ++part)
      fine.push_back(hand[n - 1] + (hand[n] - hand[n - 1]) * part / parts);
  fine.back() = hand.back();
  return fine;
}

}  // namespace

Scene random_scene(std::uint64_t seed, std::uint64_t k) {
  Chance chance(seed, k, Draw::parts), of_parts(seed, k, Draw::roll);
  for (;;) try {
      Json document = draw_document(chance);
      add_real_parts(document, of_parts);
      return parse_scene(document, "random scene");
    } catch (const BadInput&) {
    }
}

const char* name(Motion motion) noexcept {
  constexpr std::array<const char*, kMotions> names = {"insertion", "press", "jumps"};
  return names[static_cast<std::size_t>(motion)];
}

std::vector<Pose> commands(const Scene& scene, const State& start, Motion motion, double period,
                           std::uint64_t seed, std::uint64_t k, double longest) {
  Chance chance(seed, kMotions * k + static_cast<std::uint64_t>(motion), Draw::operator_hand);
  if (motion == Motion::jumps)
    return in_parts(draw_jumps(scene, start, chance), std::lround(std::max(1.0, kJump / period)));
  const double c = scene.world.annulus.clearance();
  // As far beyond the wall as stretches the holder to the force limit.
  const double pressed = 2 * c + scene.limits.force / scene.world.holder.stiffness(1, 1);
  const Wandering wandering(scene, start, chance,
                            motion == Motion::press ? std::min(pressed, 300 * c) : 1.5 * c,
                            longest);
  std::vector<Pose> hand = {start.command};
  const auto steps = std::max(1L, std::lround(wandering.duration() / period));
  for (long n = 1; n < steps; ++n) hand.push_back(wandering.at(static_cast<double>(n) * period));
  hand.push_back(start.command);
  return hand;
}

}  // namespace ferrule
