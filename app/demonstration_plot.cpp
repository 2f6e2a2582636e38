#include "app/demonstration_plot.hpp"

#include <cmath>

#include "insertion/scene_scaling.hpp"

namespace ferrule {

Plot demonstration_plot(const Episode& episode, const Scene& scene) {
  const double motion = scene_scaling(scene).motion;
  const auto column = [&](const char* name, auto value, auto style) {
    Series series{name, {}, {}, style};
    const Eigen::Index stride = std::max<Eigen::Index>(1, episode.rows.rows() / 1500);
    for (Eigen::Index n = 0; n < episode.rows.rows(); n += stride) {
      const RowVector row = episode.rows.row(n);
      series.x.push_back(row[kTime.begin]);
      series.y.push_back(1e6 * value(row));
    }
    return series;
  };
  const auto velocity = [motion](int axis) {
    return [=](const RowVector& row) { return row[kCommand.begin + axis] / motion; };
  };
  const auto term = [](int number, int axis) { return kForces.begin + 3 * number + axis; };
  const auto surface = [=](const RowVector& row) {
    return row[term(0, 1)] + row[term(1, 1)] + row[term(2, 1)] + row[term(3, 1)];
  };
  const auto contact = [=](const RowVector& row) {
    const double force = row[term(4, 1)] + row[term(6, 1)];
    return force == 0 ? NAN : force;  // dots only where there is contact
  };
  const auto felt = [](int axis) {
    return [=](const RowVector& row) { return row[kHolder.begin + axis]; };
  };
  Axes speeds{"",
              "velocity [um/s]",
              false,
              false,
              {column("v_x", velocity(0), Series::line), column("v_y", velocity(1), Series::line),
               column("v_z", velocity(2), Series::line)}};
  Axes forces{"",
              "force along y [uN]",
              false,
              false,
              {column("non-contact (5)", surface, Series::line),
               column("contact (11)", contact, Series::points)}};
  Axes holder{"time [s]",
              "felt at the holder [uN]",
              false,
              false,
              {column("F_x", felt(0), Series::line), column("F_y", felt(1), Series::line),
               column("F_z", felt(2), Series::line)}};
  return {"One demonstration, at the tip's scale", {speeds, forces, holder}, 860, 260};
}

}  // namespace ferrule
