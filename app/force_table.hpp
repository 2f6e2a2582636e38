// The force curves of a scene (the paper's Figs. 5 to 7): rows, and their plot.
#pragma once

#include <optional>
#include <vector>

#include "app/plot.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// Forces at one gap and inserted length; and at one penetration where in contact. Attraction
// negative [N]; friction, the meniscus' pull into the bore and drag are magnitudes.
struct ForceRow {
  double gap_nm, length_um;
  std::optional<double> depth_nm;  // empty: apart
  double van_der_waals, electrostatic, capillary, gravity, adhesion, wall, friction;
  double meniscus;       // along the bore
  double drag, squeeze;  // along the bore, and of the film between fibre and near wall
};

// How the fibre lies and moves where forces are asked for.
struct Lie {
  double tilt = 0;   // between the axes [rad]: the gap is then the smallest, at one end
  double speed = 0;  // along the bore for `drag`, towards the near wall for `squeeze` [m/s]
};

// The corrected laws are integrated along a tilted fibre; the printed ones, and drag, know the gap
// at its middle. That must not exceed the clearance, or the gap would not be the smallest.
ForceRow force_row(const World& world, double gap_nm, double length_um,
                   std::optional<double> depth_nm, const Lie& lie = {});

enum class Sweep { gap, length, depth };
Plot force_plot(const std::vector<ForceRow>& rows, Sweep sweep, const std::string& scene);

Json to_json(const ForceRow& row);

}  // namespace ferrule
