// Plots as SVG.
#pragma once

#include <cmath>
#include <string>
#include <vector>

namespace ferrule {

struct Series {
  std::string name;
  std::vector<double> x, y;  // points with a NaN are left out
  enum { line, points, points_on_line } style = line;
};

struct Axes {
  std::string x_label, y_label;
  bool log_x = false, log_y = false;
  std::vector<Series> series;
  double y_low = NAN, y_high = NAN;  // NaN: as the series need
};

struct Plot {
  std::string title;
  std::vector<Axes> panels;             // one above the other
  int width = 860, panel_height = 420;  // a legend below is added to the height
  bool equal_scales = false;            // one unit is as long on x as on y
};

// Without the panels that have no point. Throws FileTrouble if none has one.
std::string draw_svg(Plot plot);
void write_svg(const std::string& file, const Plot& plot);
// And says so on stderr.
void write_plot(const std::string& file, const Plot& plot);
// Makes the folder that plots go to, unless it is there. Throws FileTrouble.
void make_plot_folder(const std::string& folder);

}  // namespace ferrule
