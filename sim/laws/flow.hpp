// What the end pushes ahead of it: the fluid in the bore in front of the fibre, which leaves
// backwards through the annulus and, where the bore is open, forwards.
//
// Inserted length l, speed v into the bore, bore radius R and length L, clearance c (enlarged by
// the roughness), eccentricity eps c:
//   back through the annulus   R_back = 12 mu l/(2 pi r c^3 (1 + 1.5 eps^2))        [Pa s/m^3]
//   ahead, open bore           R_ahead = 8 mu (L - l)/(pi R^4); blind: infinite
// Liquid: the end displaces pi r^2 v and the fibre's side drags pi r c v in, whatever the
// eccentricity. That has to leave, so
//   p - p_0 = A v / (1/R_back + 1/R_ahead),   A = pi r (r + c),   F = A (p - p_0) along +x,
// which is the pressure on the end and what the same flow shears on the side (the reciprocal of the
// share that the side drags). p never falls below the vapour pressure when the fibre is pulled out:
// the liquid cavitates; that the void has to close again is left out.
// Gas in a blind bore is a cushion: isothermal (it is thinner than heat travels in a millisecond),
// of volume V = A (L - l), with the leak of a gas of that viscosity through R_back:
//   d(p V)/dt = -(p^2 - p_0^2)/(2 R_back),   F = A (p - p_0).
// How much of it there is, p V, is state (State::air). Gas in an open bore resists as a liquid.
// Left out: sideways forces of the flow in a gap that narrows along the fibre; slip of a gas in
// gaps below a micrometre (a mean free path is 0.07 um).
//
// Sources: slit and tube flow, and the thin eccentric annulus: White, Viscous Fluid Flow (2006),
// section 3-3; the leak of an ideal gas: Hamrock, Schmid and Jacobson, Fundamentals of Fluid Film
// Lubrication (2004), section 16. Orders of magnitude: adhesive of 0.1 Pa s in a blind bore, 100 um
// in at 30 um/s, 11 mN; the same in an open bore of 10.5 mm 0.76 uN; air 2 uN at most.
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule {

inline constexpr double kAtmosphere = 101325;  // p_0 [Pa]

struct Flow {
  double viscosity;            // mu [Pa s], > 0
  bool blind = false;          // closed at its far end, x = -L
  bool gas = false;            // or a liquid
  double vapour_pressure = 0;  // of a liquid [Pa], 0 to p_0

  bool cushions() const noexcept { return blind && gas; }
};

// A = pi r (r + c) [m^2].
double flow_area(const Annulus& annulus) noexcept;

// Pressure over flow [Pa s/m^3] where the end is `length` in a bore `bore_length` long [m], for the
// mean of eps^2 over the inserted length, from 0 to 1: of the way back alone, or of both.
double annulus_resistance(const Flow& law, const Annulus& annulus, double length,
                          double mean_squared_eccentricity) noexcept;
double flow_resistance(const Flow& law, const Annulus& annulus, double bore_length, double length,
                       double mean_squared_eccentricity) noexcept;

// A force along x as a function of the inserted length, over a step in time.
struct AxialForce {
  double energy = 0;     // [J]
  double force = 0;      // d energy / d length, out of the bore positive [N]
  double stiffness = 0;  // d force / d length [N/m]
};

// The flow over one step, from an inserted length to another, with the resistance per length of
// where it begins: backward Euler of the equations above.
class FlowStep {
 public:
  FlowStep() = default;  // none
  // Over `dt` [s], from `length` [m] >= 0 and p V - p_0 V = `air` [J], the mean of eps^2 being
  // that. A liquid over no time does nothing; a gas does not leak then.
  FlowStep(const Flow& law, const Annulus& annulus, double bore_length, double length,
           double mean_squared_eccentricity, double air, double dt) noexcept;

  bool acts() const noexcept { return area_ > 0; }
  // At the length [m] >= 0 that the step ends at; the energy is 0 where it begins.
  AxialForce at(double length) const noexcept;
  // p V - p_0 V there [J]; 0 but for a cushion.
  double air_at(double length) const noexcept;

 private:
  struct Cushion {
    double volume, root, pressure, over;  // V, sqrt(V^2 + 4 alpha N), p, p - p_0
  };
  Cushion cushion_at(double length) const noexcept;
  AxialForce liquid_at(double length) const noexcept;

  double area_ = 0;
  double before_ = 0;  // length where the step begins
  // Liquid: force over (l^2 - before^2)/2 [N/m^2], and the most that it pulls [N].
  double rate_ = 0, most_pull_ = 0;
  // Gas: p_1 V_1 + alpha p_1^2 = N.
  bool cushions_ = false;
  double longest_ = 0, amount_ = 0, alpha_ = 0, air_ = 0, volume_before_ = 0;
};

}  // namespace ferrule
