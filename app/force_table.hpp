// The force curves of a scene: rows, their plot and their JSON.
#pragma once

#include <vector>

#include "app/plot.hpp"
#include "sim/analysis/gap_forces.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

struct ForceRow {
  double gap_nm, length_um;        // as asked for
  std::optional<double> depth_nm;  // empty: apart
  GapForces forces;                // [N]
};

// A fibre tilted by `tilt` [rad] and moving at `speed` [m/s] (sim/analysis/gap_forces.hpp).
ForceRow force_row(const World& world, double gap_nm, double length_um,
                   std::optional<double> depth_nm, double tilt, double speed);

enum class Sweep { gap, length, depth };
Plot force_plot(const std::vector<ForceRow>& rows, Sweep sweep, const std::string& scene);

Json to_json(const ForceRow& row);

}  // namespace ferrule
