// Plots of what sweep and map found, from their JSON.
#pragma once

#include "app/plot.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// Over the first key, a line for each combination of the others.
Plot sweep_plot(const Json& result);
// The contour of the target among the points; time, force and loss in quarters of their values.
Plot map_plot(const Json& result);

// NaN where it is not a number: JSON has null there.
double number_or_nan(const Json& value);
// A value of a scene as --set takes it: 126, 125.5..126.5, 125+-0.7.
std::string setting_text(const Json& value);

}  // namespace ferrule
