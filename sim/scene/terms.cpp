#include "sim/scene/terms.hpp"

#include <algorithm>
#include <cmath>

#include "sim/scene/scene_keys.hpp"
#include "sim/terms/particle_depth.hpp"
#include "sim/terms/surface_forces.hpp"

namespace ferrule {
namespace {

// The law in the form that is stated.
template <auto law>
bool read_form(JsonFields& f, Scene& scene) {
  using Law = std::remove_cvref_t<decltype(scene.parameters.laws.*law)>;
  const bool printed = f.choice("form", {"printed", "corrected"}) == 0;
  Law& place = scene.parameters.laws.*law;
  if (printed)
    place.template emplace<1>();
  else
    place.template emplace<2>();
  return printed;
}

void read_van_der_waals(JsonFields f, Scene& scene) {
  read_form<&Laws::van_der_waals>(f, scene);
  read_numbers(f, {"hamaker_J"}, scene);
  f.finish();
}

void read_electrostatic(JsonFields f, Scene& scene) {
  read_form<&Laws::electrostatic>(f, scene);
  read_numbers(f, {"voltage_V"}, scene);
  f.finish();
}

void read_gravity(JsonFields f, Scene& scene) {
  read_form<&Laws::gravity>(f, scene);
  f.finish();
}

void read_capillary(JsonFields f, Scene& scene) {
  const bool printed = read_form<&Laws::capillary>(f, scene);
  read_numbers(f, {"surface_tension_N_m", "contact_angle_deg", "film_nm"}, scene);
  if (printed)  // may carry along what the corrected form needs
    read_numbers_if_there(f, {"volume_per_length_m2", "rupture_nm"}, scene);
  else
    read_numbers(f, {"volume_per_length_m2", "rupture_nm"}, scene);
  f.finish();
}

void read_adhesion(JsonFields f, Scene& scene) {
  const bool printed = read_form<&Laws::adhesion>(f, scene);
  read_numbers(f, {"work_of_adhesion_J_m2", "maugis_lambda"}, scene);
  if (printed)
    read_numbers(f, {"m"}, scene);
  else
    std::get<Adhesion>(scene.parameters.laws.adhesion).radius = NAN;
  read_numbers_if_there(f, {"m", "radius_um"}, scene);  // may carry along the other form's
  f.finish();
}

void read_friction(JsonFields f, Scene& scene) {
  read_form<&Laws::friction>(f, scene);
  read_numbers(f, {"burgers_nm"}, scene);
  f.finish();
}

void read_drag(JsonFields f, Scene& scene) {
  f.choice("form", {"corrected"});
  scene.parameters.laws.drag.emplace();
  read_numbers(f, {"viscosity_Pa_s"}, scene);
  f.finish();
}

void read_meniscus(JsonFields f, Scene& scene) {
  f.choice("form", {"corrected"});
  scene.parameters.laws.meniscus.emplace();
  read_numbers(f, {"surface_tension_N_m", "contact_angle_deg"}, scene);
  f.finish();
}

void read_flow(JsonFields f, Scene& scene) {
  f.choice("form", {"corrected"});
  Flow& law = scene.parameters.laws.flow.emplace();
  read_numbers(f, {"viscosity_Pa_s"}, scene);
  law.blind = f.choice("bore", {"open", "blind"}) == 1;
  law.gas = f.choice("fluid", {"liquid", "gas"}) == 1;
  if (!law.gas) read_numbers(f, {"vapour_pressure_kPa"}, scene);
  f.finish();
}

void read_particle(JsonFields f, Scene& scene) {
  f.choice("form", {"corrected"});
  scene.parameters.laws.particle.emplace();
  const bool stated = f.present("height_um");
  if (!stated || f.present("number")) read_numbers(f, {"number", "median_um", "spread"}, scene);
  if (stated) read_numbers(f, {"height_um", "at_um", "direction_deg"}, scene);
  f.finish();
}

std::string nodes(const World& world) {
  const int order = world.numerics.quadrature.order;
  return order == 1 ? "annulus, parallel axes"
                    : "tilted quadrature of order " + std::to_string(order);
}

std::string van_der_waals_fidelity(const World& world) {
  if (std::holds_alternative<printed::VanDerWaals>(world.laws.van_der_waals)) return "patch";
  return world.numerics.closed_form ? "tilted annulus closed form" : nodes(world);
}

std::string electrostatic_fidelity(const World& world) {
  if (std::holds_alternative<printed::Electrostatic>(world.laws.electrostatic)) return "patch";
  return electrostatic_in_closed_form(world) ? "tilted annulus closed form"
                                             : "exact cylinders, " + nodes(world);
}

std::string capillary_fidelity(const World& world) {
  const bool layer = std::holds_alternative<printed::Capillary>(world.laws.capillary);
  return layer ? "patch" : "bridge, nodes where it reaches";
}

std::string adhesion_fidelity(const World& world) {
  const bool prescribed = std::holds_alternative<printed::Adhesion>(world.laws.adhesion);
  return prescribed ? "prescribed radius" : "Maugis table";
}

std::string flow_fidelity(const World& world) {
  return world.laws.flow->cushions() ? "cushion with leak" : "slit and tube flow";
}

// The columns of the table that say where a law is kept.
template <auto member>
bool is_present(const Laws& laws) noexcept {
  return present(laws.*member);
}
template <auto member>
void leave_out(Laws& laws) noexcept {
  laws.*member = {};
}

template <auto member>
constexpr TermInfo row(Term term, const char* label, bool printed, void (*read)(JsonFields, Scene&),
                       std::string (*fidelity)(const World&)) {
  return {kTermNames[static_cast<std::size_t>(term)],
          label,
          printed,
          read,
          is_present<member>,
          leave_out<member>,
          fidelity};
}
template <const char* text>
std::string always(const World&) {
  return text;
}
constexpr char kWeight[] = "weight", kHertz[] = "Hertz", kStuck[] = "Hurtado-Kim, stuck spring",
               kBearing[] = "Couette and short bearing", kClosed[] = "closed form";

constexpr std::array<TermInfo, kTerms> kTable = {
    row<&Laws::van_der_waals>(Term::van_der_waals, "van der Waals", true, read_van_der_waals,
                              van_der_waals_fidelity),
    row<&Laws::electrostatic>(Term::electrostatic, "electrostatic", true, read_electrostatic,
                              electrostatic_fidelity),
    row<&Laws::gravity>(Term::gravity, "gravity", true, read_gravity, always<kWeight>),
    row<&Laws::capillary>(Term::capillary, "capillary", true, read_capillary, capillary_fidelity),
    row<&Laws::adhesion>(Term::adhesion, "adhesion", true, read_adhesion, adhesion_fidelity),
    row<&Laws::wall>(Term::wall, "wall", true, nullptr, always<kHertz>),
    row<&Laws::friction>(Term::friction, "friction", true, read_friction, always<kStuck>),
    row<&Laws::drag>(Term::drag, "drag", false, read_drag, always<kBearing>),
    row<&Laws::meniscus>(Term::meniscus, "meniscus", false, read_meniscus, always<kClosed>),
    row<&Laws::flow>(Term::flow, "flow ahead", false, read_flow, flow_fidelity),
    row<&Laws::particle>(Term::particle, "particle", false, read_particle, always<kHertz>),
};
static_assert(std::equal(kTable.begin(), kTable.end(), kTermNames.begin(),
                         [](const TermInfo& row, const char* name) { return row.name == name; }),
              "a row for each term, in their order");

}  // namespace

const TermInfo& info(Term term) noexcept {
  return kTable[static_cast<std::size_t>(term)];
}

}  // namespace ferrule
