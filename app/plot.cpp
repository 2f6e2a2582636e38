#include "app/plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "app/html.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {
namespace {

// Colours that are told apart by most colour-blind people (Okabe and Ito 2008).
constexpr std::array kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                 "#56B4E9", "#E69F00", "#000000", "#999999"};

// All in pixels.
constexpr double kTitle = 36;            // above the first panel
constexpr double kAbove = 12;            // a panel's curves
constexpr double kBelow = 58;            // them: numbers and the label of x
constexpr double kLegendLine = 20;       // of one name
constexpr double kPerTick = 65;          // at least from one number of x to the next
constexpr std::size_t kBesideUpTo = 18;  // characters: longer names stand below the curves

bool is_drawn(const Axes& axes, double x, double y) {
  return std::isfinite(x) && std::isfinite(y) && (!axes.log_x || x > 0) && (!axes.log_y || y > 0);
}

bool has_no_point(const Axes& axes) {
  for (const Series& series : axes.series)
    for (std::size_t k = 0; k < series.x.size(); ++k)
      if (is_drawn(axes, series.x[k], series.y[k])) return false;
  return true;
}

bool long_names(const Plot& plot) {
  for (const Axes& axes : plot.panels)
    for (const Series& series : axes.series)
      if (series.name.size() > kBesideUpTo) return true;
  return false;
}

// 1, 2 or 5 times a power of ten, so that at most `most` steps are in the range.
double step_of(double range, double most) {
  const double power = std::pow(10, std::floor(std::log10(range / most)));
  for (const double lead : {1, 2, 5})
    if (range <= most * lead * power) return lead * power;
  return 10 * power;
}

// Numbers along one axis; of logarithmic ones the range is that of log10.
struct Scale {
  bool log = false;
  double low = INFINITY, high = -INFINITY, most = 8;  // as many ticks

  void include(double x) {
    low = std::min(low, log ? std::log10(x) : x);
    high = std::max(high, log ? std::log10(x) : x);
  }
  double range() const { return high - low; }
  double share(double x) const { return ((log ? std::log10(x) : x) - low) / range(); }
  // One that is empty becomes a range about its number.
  void open() {
    if (range() > 0) return;
    const double around = log ? 0.5 : low != 0 ? 0.1 * std::abs(low) : 1;
    low -= around;
    high += around;
  }
  double step() const {
    return log ? std::max(1.0, step_of(range(), most)) : step_of(range(), most);
  }
  // Up to the next tick on both sides; of logarithms within a decade: a tenth of the range.
  void round_out() {
    const double to = log && range() < 1 ? 0 : step();
    low = to > 0 ? to * std::floor(low / to + 1e-9) : low - 0.1 * range();
    high = to > 0 ? to * std::ceil(high / to - 1e-9) : high + 0.1 * range();
  }
  std::vector<double> ticks() const {
    if (log && range() >= 1) {
      std::vector<double> all = multiples(step(), low, high);
      for (double& exponent : all) exponent = std::pow(10, exponent);
      return all;
    }
    if (!log) return multiples(step(), low, high);
    const double first = std::pow(10, low), last = std::pow(10, high);
    return multiples(step_of(last - first, most), first, last);
  }

 private:
  std::vector<double> multiples(double by, double from, double to) const {
    std::vector<double> all;
    const double first = std::ceil(from / by - 1e-9);
    for (double n = 0; n <= most + 1; ++n)
      if (const double at = (first + n) * by + 0.0; at <= to + 1e-9 * by) all.push_back(at);
    return all;
  }
};

struct Box {
  double x, y, width, height;
};

class Drawing {
 public:
  explicit Drawing(const Plot& plot) : plot_(plot), beside_(!long_names(plot)) {}

  std::string svg() {
    std::size_t names = 0;
    for (const Axes& axes : plot_.panels) names = std::max(names, axes.series.size());
    const double legend = beside_ ? 0 : kLegendLine * static_cast<double>(names),
                 panel = plot_.panel_height + legend,
                 height = panel * static_cast<double>(plot_.panels.size());
    add("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}\" height=\"{1}\""
        " viewBox=\"0 0 {0} {1}\" font-family=\"sans-serif\" font-size=\"14\">\n"
        "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n",
        plot_.width, height);
    text(plot_.width / 2.0, 23, "middle", plot_.title, " font-size=\"16\"");
    for (std::size_t p = 0; p < plot_.panels.size(); ++p) {
      const double top = panel * static_cast<double>(p), above = p == 0 ? kTitle : kAbove,
                   left = 0.13 * plot_.width, right = (beside_ ? 0.77 : 0.97) * plot_.width;
      draw(plot_.panels[p], {left, top + above, right - left, plot_.panel_height - above - kBelow});
    }
    return out_ + "</svg>\n";
  }

 private:
  template <class... Values>
  void add(fmt::format_string<Values...> format, Values&&... values) {
    fmt::format_to(std::back_inserter(out_), format, std::forward<Values>(values)...);
  }
  void text(double x, double y, const char* anchor, const std::string& words,
            const std::string& more = "") {
    add("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\"{}>{}</text>\n", x, y, anchor, more,
        escaped(printable(words, words.size())));
  }

  void draw(const Axes& axes, const Box& box) {
    const auto [x, y] = scales(axes, box);
    add("<g stroke=\"#dddddd\">\n");
    for (const double at : x.ticks())
      add("<path d=\"M{0:.1f},{1:.1f}V{2:.1f}\"/>\n", box.x + box.width * x.share(at), box.y,
          box.y + box.height);
    for (const double at : y.ticks())
      add("<path d=\"M{:.1f},{:.1f}H{:.1f}\"/>\n", box.x, box.y + box.height * (1 - y.share(at)),
          box.x + box.width);
    add("</g>\n<path fill=\"none\" stroke=\"#444444\" d=\"M{:.1f},{:.1f}v{:.1f}h{:.1f}\"/>\n",
        box.x, box.y, box.height, box.width);
    for (const double at : x.ticks())
      text(box.x + box.width * x.share(at), box.y + box.height + 19, "middle",
           fmt::format("{:g}", at));
    for (const double at : y.ticks())
      text(box.x - 8, box.y + box.height * (1 - y.share(at)) + 5, "end", fmt::format("{:g}", at));
    text(box.x + box.width / 2, box.y + box.height + 43, "middle", axes.x_label);
    text(0, 0, "middle", axes.y_label,
         fmt::format(" transform=\"translate(20,{:.1f}) rotate(-90)\"", box.y + box.height / 2));
    // What is beyond the range is cut off, but not half of a mark at its end.
    constexpr double kOver = 4;
    add("<svg x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" viewBox=\"{} {} {:.1f} "
        "{:.1f}\">\n",
        box.x - kOver, box.y - kOver, box.width + 2 * kOver, box.height + 2 * kOver, -kOver, -kOver,
        box.width + 2 * kOver, box.height + 2 * kOver);
    for (std::size_t i = 0; i < axes.series.size(); ++i) curve(axes, i, box, x, y);
    add("</svg>\n");
    for (std::size_t i = 0; i < axes.series.size(); ++i) {
      const double line = kLegendLine * static_cast<double>(i);
      const double left = beside_ ? box.x + box.width + 14 : box.x,
                   at = beside_ ? box.y + 10 + line : box.y + box.height + kBelow + 4 + line;
      sample(axes.series[i], i, left, at);
      text(left + 34, at + 5, "start", axes.series[i].name);
    }
  }

  std::pair<Scale, Scale> scales(const Axes& axes, const Box& box) const {
    Scale x{axes.log_x}, y{axes.log_y};
    bool lines = false;
    for (const Series& series : axes.series) {
      lines |= series.style == Series::line;
      for (std::size_t k = 0; k < series.x.size(); ++k)
        if (is_drawn(axes, series.x[k], series.y[k])) {
          x.include(series.x[k]);
          y.include(series.y[k]);
        }
    }
    x.most = std::max(2.0, box.width / kPerTick);
    x.open();
    y.open();
    if (plot_.equal_scales) {
      const double unit = 1.1 * std::max(x.range() / box.width, y.range() / box.height);
      for (const auto& [scale, length] : {std::pair{&x, box.width}, {&y, box.height}}) {
        const double middle = (scale->low + scale->high) / 2, half = unit * length / 2;
        scale->low = middle - half;
        scale->high = middle + half;
      }
      return {x, y};
    }
    if (!lines) x.round_out();  // points would be cut in half
    y.round_out();
    const auto stated = [&](double value, double& bound) {
      if (std::isfinite(value)) bound = axes.log_y ? std::log10(value) : value;
    };
    stated(axes.y_low, y.low);
    stated(axes.y_high, y.high);
    y.open();
    return {x, y};
  }

  // Beyond so many series, their colours come again, dashed or as rings.
  static bool again(std::size_t i) { return i >= kColours.size(); }
  static const char* colour(std::size_t i) { return kColours[i % kColours.size()]; }
  static std::string stroke(const Series& series, std::size_t i) {
    const bool line = series.style == Series::line;
    return fmt::format("fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"{}", colour(i), line ? 2 : 1,
                       line && again(i) ? " stroke-dasharray=\"7 4\"" : "");
  }
  static std::string mark(std::size_t i) {
    return again(i) ? fmt::format("fill=\"none\" stroke=\"{}\"", colour(i))
                    : fmt::format("fill=\"{}\"", colour(i));
  }

  void curve(const Axes& axes, std::size_t i, const Box& box, const Scale& x, const Scale& y) {
    const Series& series = axes.series[i];
    std::string path, marks, before;
    for (std::size_t k = 0; k < series.x.size(); ++k) {
      if (!is_drawn(axes, series.x[k], series.y[k])) {
        before.clear();
        continue;
      }
      const double across = box.width * x.share(series.x[k]),
                   down = box.height * (1 - y.share(series.y[k]));
      const std::string at = fmt::format("{:.1f},{:.1f}", across, std::clamp(down, -1e4, 1e4));
      if (at == before) continue;  // as another point of it
      path += (before.empty() ? "M" : "L") + at;
      marks += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{}\"/>", across, down,
                           series.style == Series::points ? 2 : 3);
      before = at;
    }
    if (series.style != Series::points) add("<path {} d=\"{}\"/>\n", stroke(series, i), path);
    if (series.style != Series::line) add("<g {}>{}</g>\n", mark(i), marks);
  }

  void sample(const Series& series, std::size_t i, double x, double y) {
    if (series.style != Series::points)
      add("<path {} d=\"M{:.1f},{:.1f}h26\"/>\n", stroke(series, i), x, y);
    if (series.style != Series::line)
      add("<circle {} cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"/>\n", mark(i), x + 13, y);
  }

  const Plot& plot_;
  bool beside_;  // the names, of the curves
  std::string out_;
};

}  // namespace

std::string draw_svg(Plot plot) {
  std::erase_if(plot.panels, has_no_point);
  if (plot.panels.empty()) throw FileTrouble("there is nothing to draw: the plot has no point");
  return Drawing(plot).svg();
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
