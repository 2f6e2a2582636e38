#include "sim/scene/world_parameters.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/elementary.hpp"
#include "sim/scene/units.hpp"

namespace ferrule {
namespace {

FerruleProfile profile(const FerruleParameters& ferrule, const Annulus& annulus) noexcept {
  FerruleProfile profile{annulus.bore_radius, 0, 0, milli * ferrule.length_mm};
  if (!ferrule.lead_in) return profile;
  const LeadIn& lead_in = *ferrule.lead_in;
  profile.lead_in_tangent = elementary::tan(0.5 * degree * lead_in.angle_deg);
  profile.lead_in_length =
      0.5 * micro * (lead_in.diameter_um - ferrule.bore_diameter_um) / profile.lead_in_tangent;
  return profile;
}

// The laws with what follows for them from geometry and materials.
Laws complete(Laws laws, const WorldParameters& p, const Annulus& annulus) {
  const double modulus = reduced_modulus(giga * p.fibre.young_GPa, p.fibre.poisson,
                                         giga * p.ferrule.young_GPa, p.ferrule.poisson);
  if (auto* law = std::get_if<Capillary>(&laws.capillary)) *law = prepare(*law, annulus);
  laws.wall = Wall{modulus, annulus.fibre_radius, 0};
  if (auto* law = std::get_if<printed::Adhesion>(&laws.adhesion)) {
    law->reduced_modulus = modulus;
    law->radius = annulus.fibre_radius;
    laws.wall->begins = printed::kDeepest;
  } else if (auto* self_consistent = std::get_if<Adhesion>(&laws.adhesion)) {
    self_consistent->reduced_modulus = modulus;
    if (std::isnan(self_consistent->radius)) self_consistent->radius = annulus.fibre_radius;
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
                       world.fibre_young, world.laws.gravity);
}

std::string shown(double x) {
  return nlohmann::json(x).dump();
}

}  // namespace

std::optional<Inconsistency> inconsistency(const WorldParameters& p) {
  if (!(p.ferrule.bore_diameter_um > p.fibre.diameter_um))
    return {{"ferrule.bore_diameter_um", "must be wider than the fibre (fibre.diameter_um = " +
                                             shown(p.fibre.diameter_um) + ")"}};
  if (p.ferrule.lead_in && !(p.ferrule.lead_in->diameter_um > p.ferrule.bore_diameter_um))
    return {
        {"ferrule.lead_in.diameter_um", "must be wider than the bore (ferrule.bore_diameter_um = " +
                                            shown(p.ferrule.bore_diameter_um) + ")"}};
  const auto* liquid = std::get_if<Capillary>(&p.laws.capillary);
  if (liquid && !(liquid->rupture > 2 * liquid->film))
    return {{"laws.capillary.rupture_nm", "must be more than twice film_nm, where a bridge forms"}};
  return std::nullopt;
}

World make_world(const WorldParameters& p) {
  World world{};
  world.annulus = {0.5 * micro * p.fibre.diameter_um, 0.5 * micro * p.ferrule.bore_diameter_um,
                   nano * p.roughness_nm};
  world.profile = profile(p.ferrule, world.annulus);
  world.fibre = {world.annulus.fibre_radius, p.fibre.density_kg_m3,
                 milli * p.fibre.manipulated_length_mm};
  world.fibre_young = giga * p.fibre.young_GPa;
  world.dynamics = p.dynamics;
  world.numerics = p.numerics;
  world.laws = complete(p.laws, p, world.annulus);
  world.holder = make_holder(p, world);
  return world;
}

}  // namespace ferrule
