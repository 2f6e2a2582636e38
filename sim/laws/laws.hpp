// The force laws of a world, and the terms they act by.
//
// A law has two forms: as the paper prints it (sim/laws/paper/), or as the literature it builds
// on has it (sim/laws/). A scene chooses law by law; one that it leaves out is empty and costs
// nothing.
#pragma once

#include <array>
#include <optional>
#include <variant>

#include "sim/laws/adhesion.hpp"
#include "sim/laws/capillary.hpp"
#include "sim/laws/drag.hpp"
#include "sim/laws/electrostatic.hpp"
#include "sim/laws/flow.hpp"
#include "sim/laws/friction.hpp"
#include "sim/laws/gravity.hpp"
#include "sim/laws/meniscus.hpp"
#include "sim/laws/paper/adhesion.hpp"
#include "sim/laws/paper/capillary.hpp"
#include "sim/laws/paper/electrostatic.hpp"
#include "sim/laws/paper/friction.hpp"
#include "sim/laws/paper/gravity.hpp"
#include "sim/laws/paper/van_der_waals.hpp"
#include "sim/laws/particle.hpp"
#include "sim/laws/van_der_waals.hpp"
#include "sim/laws/wall.hpp"

namespace ferrule {

// One force on the fibre each, in the order of their columns in files and tables. What else is
// known of a term is a row of the table in sim/scene/terms.hpp.
enum class Term {
  van_der_waals,
  electrostatic,
  gravity,
  capillary,
  adhesion,
  wall,
  friction,
  drag,
  meniscus,
  flow,
  particle
};
inline constexpr std::array kTermNames = {"van_der_waals", "electrostatic", "gravity",  "capillary",
                                          "adhesion",      "wall",          "friction", "drag",
                                          "meniscus",      "flow",          "particle"};
inline constexpr std::size_t kTerms = kTermNames.size();
static_assert(static_cast<std::size_t>(Term::particle) + 1 == kTerms);

// All of them, in order.
inline constexpr std::array<Term, kTerms> kAllTerms = [] {
  std::array<Term, kTerms> all{};
  for (std::size_t i = 0; i < kTerms; ++i) all[i] = static_cast<Term>(i);
  return all;
}();

// A law in one of its forms, or none.
template <class Printed, class Corrected>
using EitherForm = std::variant<std::monostate, Printed, Corrected>;
using GravityLaw = EitherForm<printed::Gravity, Gravity>;

struct Laws {
  EitherForm<printed::VanDerWaals, VanDerWaals> van_der_waals;
  EitherForm<printed::Electrostatic, Electrostatic> electrostatic;
  GravityLaw gravity;
  EitherForm<printed::Capillary, Capillary> capillary;
  EitherForm<printed::Adhesion, Adhesion> adhesion;
  std::optional<Wall> wall;  // empty beside the corrected adhesion, which pushes back by itself
  EitherForm<printed::Friction, Friction> friction;
  std::optional<Drag> drag;          // the paper prints none
  std::optional<Meniscus> meniscus;  // nor this
  std::optional<Flow> flow;          // nor this
  std::optional<Particle> particle;  // nor this
};

// Is the law there, in one form or the other?
template <class Printed, class Corrected>
bool present(const EitherForm<Printed, Corrected>& law) noexcept {
  return law.index() != 0;
}
template <class Law>
bool present(const std::optional<Law>& law) noexcept {
  return law.has_value();
}

// Does a force depend on how fast the fibre moves?
inline bool depends_on_speed(const Laws& laws) noexcept {
  return laws.drag || laws.flow;
}

// The printed laws of surfaces and adhesion have singular wells, narrower than what locating an
// event or a step to second order would tell.
inline bool has_printed_wells(const Laws& laws) noexcept {
  return std::holds_alternative<printed::VanDerWaals>(laws.van_der_waals) ||
         std::holds_alternative<printed::Electrostatic>(laws.electrostatic) ||
         std::holds_alternative<printed::Capillary>(laws.capillary) ||
         std::holds_alternative<printed::Adhesion>(laws.adhesion);
}

// The friction law in either form; null without friction.
inline const Friction* friction_law(const Laws& laws) noexcept {
  if (const auto* as_printed = std::get_if<printed::Friction>(&laws.friction)) return as_printed;
  return std::get_if<Friction>(&laws.friction);
}

// Magnitude of the fibre's weight along -y [N]; 0 without gravity.
inline double weight(const GravityLaw& law, const FibreMass& fibre) noexcept {
  if (const auto* as_printed = std::get_if<printed::Gravity>(&law))
    return printed::gravity(*as_printed, fibre);
  if (const auto* corrected = std::get_if<Gravity>(&law)) return gravity(*corrected, fibre);
  return 0;
}

}  // namespace ferrule
