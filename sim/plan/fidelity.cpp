#include "sim/plan/fidelity.hpp"

#include <algorithm>

namespace ferrule {

std::string fidelity(const World& world, int term) {
  const auto nodes = [&] {
    return world.quadrature.order == 1
               ? std::string("annulus, parallel axes")
               : "tilted quadrature of order " + std::to_string(world.quadrature.order);
  };
  const auto printed = [](const auto& law) { return law->form == Form::printed; };
  switch (term) {
    case 0:
      if (printed(world.van_der_waals)) return "patch";
      return world.closed_form ? "tilted annulus closed form" : nodes();
    case 1:
      if (printed(world.electrostatic)) return "patch";
      return electrostatic_in_closed_form(world) ? "tilted annulus closed form"
                                                 : "exact cylinders, " + nodes();
    case 2:
      return "weight";
    case 3:
      return printed(world.capillary) ? "patch" : "bridge, nodes where it reaches";
    case 4:
      return printed(world.adhesion) ? "prescribed radius" : "Maugis table";
    case 5:
      return "Hertz";
    case 6:
      return "Hurtado-Kim, stuck spring";
    case 7:
      return "Couette and short bearing";
    default:
      return "closed form";
  }
}

std::array<double, kSurfaceTerms> fidelity_error(const World& coarse, const World& full,
                                                 const std::vector<State>& states) {
  std::array<double, kSurfaceTerms> worst{};
  for (const State& s : states) {
    std::array<SurfaceGradients, 2> terms;
    Energy energy;
    add_surface_forces(energy, terms[0], coarse, s.inserted_length(), s.bridge, s.tip);
    add_surface_forces(energy, terms[1], full, s.inserted_length(), s.bridge, s.tip);
    for (std::size_t i = 0; i < kSurfaceTerms; ++i) {
      const PoseVector &a = terms[0][i], &b = terms[1][i];
      // A wrong moment counts as a wrong force at the lever of the inserted length.
      const double lever = s.inserted_length() + coarse.annulus.fibre_radius;
      worst[i] = std::max(worst[i], PoseVector(a.x - b.x, a.e - b.e, a.t - b.t).length() +
                                        (a.t - b.t).norm() / lever);
    }
  }
  return worst;
}

}  // namespace ferrule
