// The force curves of a scene (the paper's Figs. 5 to 7): rows, and their plot.
#pragma once

#include <optional>
#include <vector>

#include "app/plot.hpp"
#include "sim/scene.hpp"

namespace ferrule {

// Forces at one gap and inserted length, axes parallel; and at one penetration where in contact.
// Attraction negative [N]; friction is a magnitude.
struct ForceRow {
  double gap_nm, length_um;
  std::optional<double> depth_nm;  // empty: apart
  double van_der_waals, electrostatic, capillary, gravity, adhesion, wall, friction;
};

// Axes may be tilted by `tilt` [rad]: the gap is then the smallest, at one end of the inserted
// length.
ForceRow force_row(const World& world, double gap_nm, double length_um,
                   std::optional<double> depth_nm, double tilt = 0);

enum class Sweep { gap, length, depth };
Plot force_plot(const std::vector<ForceRow>& rows, Sweep sweep, const std::string& scene);

Json to_json(const ForceRow& row);

}  // namespace ferrule
