// Van der Waals, electrostatic and capillary forces along the whole inserted length.
//
// Corrected van der Waals and electrostatic forces are integrated between tilted axes in closed
// form (sim/laws/tilted_annulus.hpp); where the world asks for nodes, by Gauss-Legendre quadrature.
// So is the capillary bridge, in parts of the intervals where the gap is below its range. Corrected
// forces act along the inserted length as it changes, and so pull the fibre in by what a longer
// overlap gains; they begin smoothly within its first 10 nm. The printed ones know one gap, that at
// the middle of the length, and no axial force.
#pragma once

#include <array>

#include "sim/geometry/energy.hpp"
#include "sim/model/world.hpp"

namespace ferrule {

enum SurfaceTerm { kVanDerWaals, kElectrostatic, kCapillary, kSurfaceTerms };
inline constexpr std::array<Term, kSurfaceTerms> kSurfaceTermTable = {
    Term::van_der_waals, Term::electrostatic, Term::capillary};

// Gradient of each term's energy: minus its force and moment [N, N m].
using SurfaceGradients = std::array<PoseVector, kSurfaceTerms>;

// Adds them to `total` at `tip`, and each term's part to `by_term`. `printed_length` [m] is what
// the printed forces act along, `bridge` whether liquid spans the gap.
void add_surface_forces(Energy& total, SurfaceGradients& by_term, const World& world,
                        double printed_length, bool bridge, const PoseVector& tip) noexcept;

// The printed ones per length at a gap h [m].
bool has_printed_forces(const World& world) noexcept;
LineForce printed_forces(const World& world, double h) noexcept;

// Whether the corrected electrostatic force is taken in closed form in this world.
bool electrostatic_in_closed_form(const World& world) noexcept;

// Whether liquid spans the gap at `tip`: it does up to the bridge's range.
bool bridge_at(const World& world, bool bridge, const PoseVector& tip) noexcept;

}  // namespace ferrule
