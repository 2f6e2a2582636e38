#include "sim/scene/terms.hpp"

#include <algorithm>
#include <cmath>

#include "sim/base/units.hpp"
#include "sim/terms/particle_depth.hpp"
#include "sim/terms/surface_forces.hpp"

namespace ferrule {
namespace {

bool read_printed(JsonFields& law) {
  return law.choice("form", {"printed", "corrected"}) == 0;
}

template <class Law>
void read_wetting(JsonFields& f, Law& law) {
  f.number("surface_tension_N_m", rule::positive(1e-30, 3), law.surface_tension);
  Rule wetting = rule::between(0, 90, "must be at least 0 and below 90 degrees");
  wetting.high_open = true;
  f.number("contact_angle_deg", wetting, law.contact_angle, degree);
}

void read_van_der_waals(JsonFields f, Laws& laws) {
  double& hamaker = read_printed(f) ? laws.van_der_waals.emplace<printed::VanDerWaals>().hamaker
                                    : laws.van_der_waals.emplace<VanDerWaals>().hamaker;
  f.number("hamaker_J", rule::positive(1e-40, 1e-17), hamaker);
  f.finish();
}

void read_electrostatic(JsonFields f, Laws& laws) {
  double& voltage = read_printed(f) ? laws.electrostatic.emplace<printed::Electrostatic>().voltage
                                    : laws.electrostatic.emplace<Electrostatic>().voltage;
  f.number("voltage_V", rule::not_negative(1e5), voltage);
  f.finish();
}

void read_gravity(JsonFields f, Laws& laws) {
  if (read_printed(f))
    laws.gravity = printed::Gravity{};
  else
    laws.gravity = Gravity{};
  f.finish();
}

template <class Law>
void read_liquid(JsonFields& f, Law& law) {
  read_wetting(f, law);
  f.number("film_nm", rule::positive(1e-3, 1e6), law.film, nano);
}

void read_capillary(JsonFields f, Laws& laws) {
  const Rule volume = rule::positive(1e-20, 1e-6), rupture = rule::positive(1e-3, 1e6);
  if (read_printed(f)) {
    read_liquid(f, laws.capillary.emplace<printed::Capillary>());
    // Of the corrected form; may be carried along.
    if (f.present("volume_per_length_m2")) f.number("volume_per_length_m2", volume);
    if (f.present("rupture_nm")) f.number("rupture_nm", rupture);
  } else {
    Capillary& law = laws.capillary.emplace<Capillary>();
    read_liquid(f, law);
    f.number("volume_per_length_m2", volume, law.volume);
    f.number("rupture_nm", rupture, law.rupture, nano);
  }
  f.finish();
}

void read_adhesion(JsonFields f, Laws& laws) {
  const Rule work = rule::positive(1e-9, 1e3), radius = rule::positive(1e-3, 1e6);
  const Rule m = rule::between(1, 1e3, "must be at least 1, at most 1000");
  if (read_printed(f)) {
    auto& law = laws.adhesion.emplace<printed::Adhesion>();
    f.number("work_of_adhesion_J_m2", work, law.work_of_adhesion);
    f.number("maugis_lambda", rule::between(0.12, 5.8, "must be from 0.12 to 5.8"),
             law.maugis_lambda);
    f.number("m", m, law.m);
    if (f.present("radius_um")) f.number("radius_um", radius);  // of the corrected form
  } else {
    auto& law = laws.adhesion.emplace<Adhesion>();
    f.number("work_of_adhesion_J_m2", work, law.work_of_adhesion);
    f.number("maugis_lambda", rule::between(0.01, 100, "must be from 0.01 to 100"),
             law.maugis_lambda);
    if (f.present("m")) f.number("m", m);  // of the printed form
    law.radius = NAN;
    if (f.present("radius_um")) f.number("radius_um", radius, law.radius, micro);
  }
  f.finish();
}

void read_friction(JsonFields f, Laws& laws) {
  Friction& law = read_printed(f) ? laws.friction.emplace<printed::Friction>()
                                  : laws.friction.emplace<Friction>();
  f.number("burgers_nm", rule::positive(1e-6, 1e3), law.burgers, nano);
  f.finish();
}

void read_drag(JsonFields f, Laws& laws) {
  f.choice("form", {"corrected"});
  f.number("viscosity_Pa_s", rule::positive(1e-30, 1e6), laws.drag.emplace().viscosity);
  f.finish();
}

void read_meniscus(JsonFields f, Laws& laws) {
  f.choice("form", {"corrected"});
  Meniscus& law = laws.meniscus.emplace();
  read_wetting(f, law);
  f.finish();
}

void read_flow(JsonFields f, Laws& laws) {
  f.choice("form", {"corrected"});
  Flow& law = laws.flow.emplace();
  f.number("viscosity_Pa_s", rule::positive(1e-30, 1e6), law.viscosity);
  law.blind = f.choice("bore", {"open", "blind"}) == 1;
  law.gas = f.choice("fluid", {"liquid", "gas"}) == 1;
  if (!law.gas)
    f.number("vapour_pressure_kPa",
             rule::between(0, 1e-3 * kAtmosphere, "must be from 0 to 101.325"), law.vapour_pressure,
             1e3);
  f.finish();
}

void read_particle(JsonFields f, Laws& laws) {
  f.choice("form", {"corrected"});
  Particle& law = laws.particle.emplace();
  const bool stated = f.present("height_um");
  if (!stated || f.present("number")) {
    f.number("number", rule::between(0, 1000, "must be from 0 to 1000"), law.number);
    f.number("median_um", rule::positive(1e-3, 100), law.median, micro);
    f.number("spread", rule::between(0, 3, "must be from 0 to 3"), law.spread);
  }
  if (stated) {
    f.number("height_um", rule::between(0, 1e6 * kHighestParticle, "must be from 0 to 1000"),
             law.height, micro);
    f.number("at_um", rule::not_negative(1e7), law.depth, micro);
    f.number("direction_deg", rule::between(-360, 360, "must be from -360 to 360"), law.direction,
             degree);
  }
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
constexpr TermInfo row(Term term, const char* label, bool printed, void (*read)(JsonFields, Laws&),
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
