// One force law alone: van der Waals attraction per length against the gap, as the paper prints it
// and as the literature has it, and what the energy says about the force.
#include <cmath>
#include <cstdio>

#include "sim/laws/paper/van_der_waals.hpp"
#include "sim/laws/van_der_waals.hpp"

int main() {
  using namespace ferrule;
  const Annulus annulus{62.5e-6, 63e-6};  // radii of fibre and bore [m]
  const double hamaker = 3.67e-19;        // [J]
  const printed::VanDerWaals printed{hamaker};
  const VanDerWaals corrected{hamaker};

  std::printf("%8s %14s %14s   [uN per mm of fibre]\n", "gap [nm]", "printed", "corrected");
  for (double gap = 1e-9; gap < 100e-9; gap *= 2)
    std::printf("%8.0f %14.6g %14.6g\n", 1e9 * gap,
                1e3 * van_der_waals(printed, annulus, gap).force,
                1e3 * van_der_waals(corrected, annulus, gap).force);

  // A law is a potential, the force that follows from it, and that force's slope.
  for (double gap = 1e-9; gap < 100e-9; gap *= 2) {
    const double h = 1e-4 * gap;
    const LineForce at = van_der_waals(corrected, annulus, gap);
    const LineForce more = van_der_waals(corrected, annulus, gap + h);
    const LineForce less = van_der_waals(corrected, annulus, gap - h);
    const double force = -(more.potential - less.potential) / (2 * h);
    const double slope = (more.force - less.force) / (2 * h);
    if (!(at.force < 0) || std::abs(force / at.force - 1) > 1e-6 ||
        std::abs(slope / at.slope - 1) > 1e-6)
      return 1;
  }
  // Centred in the bore, both walls pull alike.
  return std::abs(van_der_waals(corrected, annulus, annulus.clearance()).force) < 1e-15 ? 0 : 1;
}
