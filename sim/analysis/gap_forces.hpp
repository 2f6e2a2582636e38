// The forces between fibre and bore at a gap, an inserted length and a penetration that are given:
// the curves of the paper's Figs. 5 to 7. Nothing moves or is in equilibrium here.
#pragma once

#include <array>
#include <functional>
#include <optional>

#include "sim/model/world.hpp"

namespace ferrule {

// How the fibre lies and moves where forces are asked for.
struct Posture {
  double gap;                   // smallest, of fibre and bore [m]
  double length;                // inserted [m], >= 0
  std::optional<double> depth;  // penetration of a closed contact [m], >= 0; empty: apart
  double tilt = 0;              // between the axes [rad], >= 0: the gap is the smallest at one end
  double speed = 0;  // along the bore for drag, towards the near wall for `squeeze` [m/s]

  double rise() const noexcept { return length * tilt; }  // of the gap over the length [m]
};

// Term by term along the line of the smallest gap, attraction negative [N]; friction, the meniscus'
// pull into the bore, drag and flow ahead are magnitudes. Zero for what the world does not model.
struct GapForces {
  std::array<double, kTerms> terms{};
  double squeeze = 0;  // of the film between fibre and near wall

  double operator[](Term term) const noexcept { return terms[static_cast<std::size_t>(term)]; }
};

// Of one term that the world models, as in GapForces [N].
double force_at_gap(const World& world, Term term, const Posture& posture);

// A liquid bridge is there up to its rupture. The corrected laws are integrated along a tilted
// fibre; the printed ones, and drag, know the gap at its middle, gap + length tilt/2. That must not
// exceed the clearance, or the gap would not be the smallest.
GapForces gap_forces(const World& world, const Posture& posture);

// Throws BadInput unless a gap [nm] can be the smallest of a fibre that is so far in [um] and
// tilted by so much [mrad]: that at its middle must not exceed the clearance. Worlds of printed
// laws without tilt know no other wall: there any gap is right.
void expect_fits(const World& world, double gap_nm, double length_um, double tilt_mrad);

// Throws BadInput unless a fibre can be so far in [um]: no farther than the bore is long.
void expect_in_bore(const World& world, double length_um);

// Mean over the inserted length of a corrected force per length that ends at the gap `reach` [m].
double mean_line_force(const std::function<double(double)>& law, const World& world, double reach,
                       const Posture& posture);

}  // namespace ferrule
