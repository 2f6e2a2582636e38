#include "app/compare_plot.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

Axes percent_axes(const char* x_label) {
  Axes axes;
  axes.x_label = x_label;
  axes.y_label = "inserted [%]";
  axes.y_low = -2;
  axes.y_high = 102;
  return axes;
}

double percent(std::size_t part, std::size_t all) {
  return all > 0 ? 100 * static_cast<double>(part) / static_cast<double>(all) : NAN;
}

}  // namespace

std::vector<Ring> by_misalignment(const std::vector<TrialResult>& results,
                                  const std::vector<Vector2d>& starts) {
  constexpr std::size_t kRings = 8;
  std::vector<std::size_t> order(std::min(starts.size(), results.size()));
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return starts[a].norm() < starts[b].norm(); });
  std::vector<Ring> rings;
  for (std::size_t i = 0; i < kRings; ++i) {
    const std::size_t begin = order.size() * i / kRings, end = order.size() * (i + 1) / kRings;
    if (begin == end) continue;
    Ring ring{starts[order[begin]].norm(), starts[order[end - 1]].norm(), 0, 0};
    for (std::size_t k = begin; k < end; ++k) {
      const Outcome outcome = results[order[k]].outcome;
      ring.feasible += outcome != Outcome::infeasible;
      ring.inserted += outcome == Outcome::inserted;
    }
    rings.push_back(ring);
  }
  return rings;
}

Plot misalignment_plot(const std::vector<Entry>& entries) {
  Axes axes = percent_axes("distance of the start from the axis [um]");
  for (const Entry& e : entries) {
    Series series{e.name, {}, {}, Series::points_on_line};
    for (const Ring& ring : e.rings) {
      series.x.push_back(0.5e6 * (ring.from + ring.to));
      series.y.push_back(percent(ring.inserted, ring.feasible));
    }
    axes.series.push_back(series);
  }
  return {"Success against misalignment", {axes}};
}

Plot learning_plot(const std::vector<LearnedAgain>& learning) {
  Axes axes = percent_axes("demonstrations");
  axes.log_x = true;
  for (const LearnedAgain& l : learning) {
    auto series = std::find_if(axes.series.begin(), axes.series.end(),
                               [&](const Series& s) { return s.name == l.name; });
    if (series == axes.series.end())
      series = axes.series.insert(axes.series.end(), {l.name, {}, {}, Series::points_on_line});
    const auto x = static_cast<double>(l.fit->demonstrations);
    const double y = 100 * l.summary.success_rate;
    const auto known = std::find(series->x.begin(), series->x.end(), x);
    if (known == series->x.end()) {
      series->x.push_back(x);
      series->y.push_back(y);
    } else {
      double& worst = series->y[static_cast<std::size_t>(known - series->x.begin())];
      worst = std::min(worst, y);
    }
  }
  return {"Success against the number of demonstrations", {axes}};
}

Plot rung_plot(const std::vector<LadderRow>& rung) {
  Axes axes = percent_axes("trials in the order of that number [%]");
  for (const LadderRow& row : rung) {
    const Deciding& decided = row.deciding;
    Series series{
        fmt::format("{}: {} of {:.4g} to {:.4g} ({:.0f} %)", row.controller, decided.name,
                    decided.tenths.front().low, decided.tenths.back().high, 100 * decided.share),
        {},
        {},
        Series::points_on_line};
    for (const Tenth& tenth : decided.tenths) {
      series.x.push_back(10 * static_cast<double>(series.x.size()) + 5);
      series.y.push_back(percent(tenth.successes, tenth.trials));
    }
    axes.series.push_back(series);
  }
  return {rung.front().rung +
              ": success against the number that decides it (its share of the variance)",
          {axes}};
}

Plot failure_map(const std::string& controller, const std::vector<TrialResult>& results,
                 const std::vector<Vector2d>& starts) {
  Series inserted{"inserted", {}, {}, Series::points}, failed{"not", {}, {}, Series::points};
  for (std::size_t k = 0; k < std::min(starts.size(), results.size()); ++k) {
    if (results[k].outcome == Outcome::infeasible) continue;
    Series& series = results[k].outcome == Outcome::inserted ? inserted : failed;
    series.x.push_back(1e6 * starts[k].x());
    series.y.push_back(1e6 * starts[k].y());
  }
  Axes axes;
  axes.x_label = "start y [um]";
  axes.y_label = "start z [um]";
  for (const Series& series : {inserted, failed})
    if (!series.x.empty()) axes.series.push_back(series);
  return {"Starts of the trials: " + controller, {axes}, 640, 560, true};
}

}  // namespace ferrule
