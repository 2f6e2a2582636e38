#include "app/plot.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <boost/algorithm/string/replace.hpp>
#include <cctype>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>

#include "sim/base/child_process.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

// Colours that are told apart by most colour-blind people (Okabe and Ito 2008).
constexpr std::array kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                 "#56B4E9", "#E69F00", "#000000", "#999999"};

// A string in double quotes in which every mark is an octal number: gnuplot 5.4 does not read two
// apostrophes side by side, and runs what stands in backquotes.
std::string quoted(const std::string& text) {
  std::string line = text, out;
  std::replace_if(
      line.begin(), line.end(), [](char c) { return c >= 0 && c < ' '; }, ' ');
  for (const char c : printable(line, line.size())) {  // an SVG is UTF-8
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = byte >= 0x80 || std::isalnum(byte) || c == ' ';
    out += plain ? std::string(1, c) : fmt::format("\\{}{:03o}", byte < 0100 ? "0" : "", byte);
  }
  return '"' + out + '"';
}

// Names that do not fit beside the curves go below them.
bool long_names(const Plot& plot) {
  for (const Axes& axes : plot.panels)
    for (const Series& series : axes.series)
      if (series.name.size() > 18) return true;
  return false;
}

// Height of a legend below a panel.
int legend_height(const Plot& plot) {
  std::size_t names = 0;
  for (const Axes& axes : plot.panels) names = std::max(names, axes.series.size());
  return long_names(plot) ? 20 * static_cast<int>(names) : 0;
}

bool is_drawn(const Axes& axes, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!axes.log_x || x > 0) && (!axes.log_y || y > 0);
}

bool has_no_point(const Axes& axes) {
  for (const Series& series : axes.series)
    for (std::size_t k = 0; k < series.x.size(); ++k)
      if (is_drawn(axes, series.x[k], series.y[k])) return false;
  return true;
}

std::string script(const Plot& plot) {
  const int panels = static_cast<int>(plot.panels.size());
  const bool legend_below = long_names(plot);
  std::string s = fmt::format(
      "set encoding utf8\n"
      "set terminal svg size {},{} dynamic enhanced font 'sans-serif,14' background '#ffffff'\n"
      "set multiplot layout {},1 title {} noenhanced\n"
      "set border 3 lc rgb '#444444'\nset tics nomirror\nset grid lc rgb '#dddddd'\n"
      "set key {} noenhanced\nset format '%g'\n"
      "set lmargin at screen 0.13\nset rmargin at screen {}\n{}",
      plot.width, panels * (plot.panel_height + legend_height(plot)), panels, quoted(plot.title),
      legend_below ? "below maxcols 2" : "outside right top", legend_below ? 0.95 : 0.77,
      plot.equal_scales ? "set size ratio -1\nset offsets graph 0.05, 0.05, 0.05, 0.05\n" : "");
  for (int p = 0; p < panels; ++p) {
    const Axes& axes = plot.panels[static_cast<std::size_t>(p)];
    std::string command = "plot ";
    const bool lines = std::any_of(axes.series.begin(), axes.series.end(),
                                   [](const Series& one) { return one.style == Series::line; });
    s += lines ? "set autoscale xfix\n" : "set autoscale x\n";  // points would be cut in half
    for (std::size_t i = 0; i < axes.series.size(); ++i) {
      const Series& series = axes.series[i];
      s += fmt::format("$d{}_{} << EOD\n", p, i);
      for (std::size_t k = 0; k < series.x.size(); ++k) {
        const double x = series.x[k], y = series.y[k];
        s += is_drawn(axes, x, y) ? fmt::format("{} {}\n", x, y) : std::string("\n");
      }
      s += "EOD\n";
      const char* colour = kColours[i % kColours.size()];
      const bool again = i >= kColours.size();  // the same colours, dashed or with rings
      command += fmt::format(
          "{}$d{}_{} using 1:2 {}{} lc rgb '{}' title {}", i ? ", " : "", p, i,
          series.style == Series::line             ? "with lines lw 2"
          : series.style == Series::points_on_line ? "with linespoints lw 1 ps 0.6"
                                                   : "with points ps 0.35",
          series.style == Series::line ? (again ? " dt 2" : "") : (again ? " pt 6" : " pt 7"),
          colour, quoted(series.name));
    }
    s += fmt::format("{} logscale x\n{} logscale y\n", axes.log_x ? "set" : "unset",
                     axes.log_y ? "set" : "unset");
    const auto bound = [](double y) { return std::isfinite(y) ? fmt::format("{}", y) : "*"; };
    s += fmt::format("set yrange [{}:{}]\n", bound(axes.y_low), bound(axes.y_high));
    s += fmt::format("set xlabel {}{} noenhanced\nset ylabel {} noenhanced\n", quoted(axes.x_label),
                     legend_below ? ".\"\\n \"" : "", quoted(axes.y_label));
    s += command + "\n";
  }
  return s + "unset multiplot\n";
}

}  // namespace

std::string draw_svg(Plot plot) {
  std::erase_if(plot.panels, has_no_point);  // which gnuplot refuses
  if (plot.panels.empty()) throw FileTrouble("there is nothing to draw: the plot has no point");
  const std::string text = script(plot);
  const int in = ::memfd_create("plot", MFD_CLOEXEC);
  int ends[2] = {-1, -1};
  if (in < 0 || write_all(in, text.data(), text.size()) != 0 || ::lseek(in, 0, SEEK_SET) != 0 ||
      ::pipe2(ends, O_CLOEXEC) != 0) {
    ::close(in);
    throw FileTrouble(std::string("gnuplot cannot be started: ") + std::strerror(errno));
  }
  ChildProcess gnuplot({in, ends[1]}, [&] { execute({"gnuplot", "-d"}, in, ends[1], -1); });
  ::close(in);
  ::close(ends[1]);
  std::string svg;
  std::array<char, 65536> part;
  for (ssize_t n = 1; n > 0 || (n < 0 && errno == EINTR);) {
    n = ::read(ends[0], part.data(), part.size());
    if (n > 0) svg.append(part.data(), static_cast<std::size_t>(n));
  }
  ::close(ends[0]);
  if (gnuplot.wait() != 0 || svg.find("</svg>") == svg.npos)
    throw FileTrouble("gnuplot could not draw the plot (is the package gnuplot-nox installed?)");
  return boost::replace_all_copy(svg, "]]>", "]]&gt;");  // all that it does not escape of a name
}

void write_svg(const std::string& file, const Plot& plot) {
  write_text(file, draw_svg(plot));
}

void write_plot(const std::string& file, const Plot& plot) {
  write_svg(file, plot);
  fmt::print(stderr, "wrote {}\n", printable(file));
}

void make_plot_folder(const std::string& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error) throw FileTrouble(folder + ": cannot be made: " + error.message());
}

}  // namespace ferrule
