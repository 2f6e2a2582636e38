#include "sim/scene/world_parameters.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "sim/base/elementary.hpp"
#include "sim/base/units.hpp"
#include "sim/geometry/curl.hpp"
#include "sim/laws/corrected_range.hpp"

namespace ferrule {
namespace {

Annulus annulus_of(const WorldParameters& p) noexcept {
  return {0.5 * micro * p.fibre.diameter_um, 0.5 * micro * p.ferrule.bore_diameter_um,
          nano * p.roughness_nm};
}

FerruleProfile profile(const FerruleParameters& ferrule, const Annulus& annulus) noexcept {
  FerruleProfile profile{annulus.bore_radius, 0, 0, milli * ferrule.length_mm};
  if (!ferrule.lead_in) return profile;
  const LeadIn& lead_in = *ferrule.lead_in;
  profile.lead_in_tangent = elementary::tan(0.5 * degree * lead_in.angle_deg);
  profile.lead_in_length =
      0.5 * micro * (lead_in.diameter_um - ferrule.bore_diameter_um) / profile.lead_in_tangent;
  return profile;
}

// R_s of the contacts: the fibre's radius, or for a rounded rim, curved by rho one way and by r the
// other, that of the sphere with the same pull-off (Johnson and Greenwood 2005), sqrt(rho r).
double contact_radius(const FibreParameters& fibre) noexcept {
  const double r = 0.5 * fibre.diameter_um;
  return micro * (fibre.edge_um ? std::sqrt(*fibre.edge_um * r) : r);
}

double modulus(const WorldParameters& p) noexcept {
  return reduced_modulus(giga * p.fibre.young_GPa, p.fibre.poisson, giga * p.ferrule.young_GPa,
                         p.ferrule.poisson);
}

// Radius that the end's rim is rounded to [m]; 0: sharp.
double rim_radius(const FibreParameters& fibre) noexcept {
  return micro * fibre.edge_um.value_or(0);
}

// The laws with what follows for them from geometry and materials.
Laws complete(Laws laws, const WorldParameters& p, const Annulus& annulus) {
  if (auto* law = std::get_if<Capillary>(&laws.capillary)) *law = prepare(*law, annulus);
  const double radius = contact_radius(p.fibre);
  laws.wall = Wall{modulus(p), radius, 0};
  if (auto* law = std::get_if<printed::Adhesion>(&laws.adhesion)) {
    law->reduced_modulus = modulus(p);
    law->radius = radius;
    *law = prepare(*law);
    laws.wall->begins = printed::kDeepest;
  } else if (auto* self_consistent = std::get_if<Adhesion>(&laws.adhesion)) {
    self_consistent->reduced_modulus = modulus(p);
    if (std::isnan(self_consistent->radius)) self_consistent->radius = radius;
    *self_consistent = prepare(*self_consistent);
    laws.wall.reset();
  }
  for (Friction* law : {std::get_if<Friction>(&laws.friction),
                        static_cast<Friction*>(std::get_if<printed::Friction>(&laws.friction))})
    if (law) {
      law->shear_fibre = giga * p.fibre.shear_GPa;
      law->shear_ferrule = giga * p.ferrule.shear_GPa;
    }
  return laws;
}

Holder make_holder(const WorldParameters& p, const World& world) {
  if (const auto* hand = std::get_if<RigidHand>(&p.holder))
    return rigid_hand(hand->stiffness_N_m, hand->tilt_stiffness_N_m_rad, world.fibre,
                      world.fibre_young, world.laws.gravity);
  const auto& elastic = std::get<ElasticFibre>(p.holder);
  return elastic_fibre(milli * elastic.free_length_mm, elastic.gripper_stiffness_N_m, world.fibre,
                       world.fibre_young, world.laws.gravity, elastic.loss_factor);
}

constexpr double kLeastCurl = 10;  // radius over free length: a slope of 0.1

std::string shown(double x) {
  return nlohmann::json(x).dump();
}

// A voltage that no surfaces bear where they come closest (kGreatestField).
std::optional<Inconsistency> unbearable_field(const WorldParameters& p) {
  const auto* law = std::get_if<Electrostatic>(&p.laws.electrostatic);
  const double closest = corrected::asperity_range(annulus_of(p));
  if (!law || law->voltage <= kGreatestField * closest * (1 + 1e-9)) return std::nullopt;
  return {{"laws.electrostatic.voltage_V", "must be at most " + shown(kGreatestField * closest) +
                                               " where roughness_nm is " + shown(p.roughness_nm) +
                                               ", or roughness_nm at least " +
                                               shown(law->voltage / kGreatestField / nano) +
                                               ": no surface keeps a field above 1e10 V/m"}};
}

}  // namespace

double usual_tangent_tip(const WorldParameters& p) noexcept {
  return kUsualTangent * annulus_of(p).clearance();
}

double free_length(const WorldParameters& p) noexcept {
  const auto* elastic = std::get_if<ElasticFibre>(&p.holder);
  return milli * (elastic ? elastic->free_length_mm : p.fibre.manipulated_length_mm);
}

std::optional<FreeCurl> free_curl(const WorldParameters& p) noexcept {
  if (!p.fibre.curl_radius_m) return std::nullopt;
  const double length = free_length(p), r = 0.5 * micro * p.fibre.diameter_um;
  const Pose end = curl(*p.fibre.curl_radius_m, length, Vector2d::UnitX());
  const double bending = giga * p.fibre.young_GPa * 0.25 * std::numbers::pi * r * r * r * r;
  return FreeCurl{end[1], -end[3], 1.5 * bending / (*p.fibre.curl_radius_m * length)};
}

std::optional<Inconsistency> inconsistency(const WorldParameters& p) {
  if (!(p.ferrule.bore_diameter_um > p.fibre.diameter_um))
    return {{"ferrule.bore_diameter_um", "must be wider than the fibre (fibre.diameter_um = " +
                                             shown(p.fibre.diameter_um) + ")"}};
  if (p.ferrule.lead_in && !(p.ferrule.lead_in->diameter_um > p.ferrule.bore_diameter_um))
    return {
        {"ferrule.lead_in.diameter_um", "must be wider than the bore (ferrule.bore_diameter_um = " +
                                            shown(p.ferrule.bore_diameter_um) + ")"}};
  const auto* adhesion = std::get_if<printed::Adhesion>(&p.laws.adhesion);
  if (adhesion && !(adhesion->maugis_lambda >= 0.12 && adhesion->maugis_lambda <= 5.8))
    return {{"laws.adhesion.maugis_lambda", "must be from 0.12 to 5.8"}};
  const auto* liquid = std::get_if<Capillary>(&p.laws.capillary);
  if (liquid && !(liquid->rupture > 2 * liquid->film))
    return {{"laws.capillary.rupture_nm", "must be more than twice film_nm, where a bridge forms"}};
  if (auto found = unbearable_field(p)) return found;
  if (p.ferrule.ovality_um &&
      !(*p.ferrule.ovality_um <= kMostOval * (p.ferrule.bore_diameter_um - p.fibre.diameter_um)))
    return {
        {"ferrule.ovality_um", "must be at most 0.6 of what the bore is wider than the fibre (" +
                                   shown(p.ferrule.bore_diameter_um - p.fibre.diameter_um) + ")"}};
  if (p.fibre.edge_um && !(*p.fibre.edge_um <= 0.25 * p.fibre.diameter_um))
    return {{"fibre.edge_um", "must be at most a quarter of the fibre's diameter (" +
                                  shown(p.fibre.diameter_um) + ")"}};
  if (const auto& law = p.laws.particle;
      law && law->height > 0 && !(law->depth >= shallowest(p, law->height)))
    return {{"laws.particle.at_um", "must be at least " + shown(1e6 * shallowest(p, law->height)) +
                                        ", where all of it is in the bore"}};
  if (p.fibre.curl_radius_m && !(*p.fibre.curl_radius_m >= kLeastCurl * free_length(p)))
    return {{"fibre.curl_radius_m", "must be at least ten times the length that is free (" +
                                        shown(free_length(p)) + " m)"}};
  return std::nullopt;
}

OvalBore oval_bore(const WorldParameters& p) noexcept {
  if (!p.ferrule.ovality_um || *p.ferrule.ovality_um == 0) return {};
  const double direction = degree * p.ferrule.ovality_direction_deg.value_or(0);
  return {micro * *p.ferrule.ovality_um,
          0.5 * micro * (p.ferrule.bore_diameter_um - p.fibre.diameter_um),
          Vector2d(elementary::cos(direction), elementary::sin(direction))};
}

FibreEnd fibre_end(const FibreParameters& fibre) noexcept {
  const double direction =
      degree * (fibre.roll_deg.value_or(0) + fibre.cleave_direction_deg.value_or(0));
  const double slope = elementary::tan(degree * fibre.cleave_deg.value_or(0));
  const double edge = rim_radius(fibre);
  return {slope * Vector2d(elementary::cos(direction), elementary::sin(direction)), edge,
          0.5 * micro * fibre.diameter_um * std::abs(slope) + edge};
}

double shallowest(const WorldParameters& p, double height) noexcept {
  const double tangent =
      p.ferrule.lead_in ? elementary::tan(0.5 * degree * p.ferrule.lead_in->angle_deg) : 0.0;
  return shallowest(height, rim_radius(p.fibre), tangent);
}

std::optional<Particle> particle(const WorldParameters& p) noexcept {
  std::optional<Particle> law = p.laws.particle;
  if (!law) return law;
  if (std::isnan(law->height)) {
    const double clearance = 0.5 * micro * (p.ferrule.bore_diameter_um - p.fibre.diameter_um);
    law->height = std::min(unusual_height(*law), clearance);
    law->depth = shallowest(p, law->height);
  }
  if (law->height == 0) return std::nullopt;
  law->outward = {elementary::cos(law->direction), elementary::sin(law->direction)};
  law->reduced_modulus = modulus(p);
  return law;
}

World make_world(const WorldParameters& p) {
  World world{};
  world.annulus = annulus_of(p);
  world.oval = oval_bore(p);
  world.end = fibre_end(p.fibre);
  world.profile = profile(p.ferrule, world.annulus);
  world.fibre = {world.annulus.fibre_radius, p.fibre.density_kg_m3,
                 milli * p.fibre.manipulated_length_mm};
  world.fibre_young = giga * p.fibre.young_GPa;
  world.dynamics = p.dynamics;
  world.numerics = p.numerics;
  world.laws = complete(p.laws, p, world.annulus);
  world.laws.particle = particle(p);
  world.holder = make_holder(p, world);
  return world;
}

}  // namespace ferrule
