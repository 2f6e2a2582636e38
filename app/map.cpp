// ferrule map: over two numbers of the scene, where a controller inserts as often as it is to.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <chrono>
#include <map>
#include <set>

#include "app/shards.hpp"
#include "app/validators.hpp"
#include "app/varied_plots.hpp"
#include "app/varied_scene.hpp"
#include "controller/refined_grid.hpp"

namespace ferrule {
namespace {

struct MapArguments : VariedArguments {
  std::vector<std::string> keys;
  std::string plot;
  double target = 0.99, width = 1.0 / 32;
  double seconds = 120;  // at most
};

// KEY=low..high[:log].
struct Axis {
  std::string key;
  double low, high;
  bool log;

  double at(double share) const { return interpolate(low, high, share, log); }
};

Axis axis(const std::string& text) {
  const auto refuse = [&](const char* why) { throw BadInput("map " + text + ": " + why); };
  const auto equals = text.find('=');
  if (equals == text.npos || equals == 0) refuse("must be KEY=low..high or KEY=low..high:log");
  std::string range = text.substr(equals + 1);
  const bool log = range.ends_with(":log");
  if (log) range.resize(range.size() - 4);
  const std::optional<Json> uniform = distribution_of(range);
  if (!uniform || !uniform->contains("uniform"))
    refuse("must be KEY=low..high or KEY=low..high:log");
  const Json& ends = uniform->at("uniform");
  Axis a{text.substr(0, equals), ends[0], ends[1], log};
  if (!(a.low < a.high)) refuse("low must be below high");
  if (log && !(a.low > 0)) refuse("a logarithmic range must be positive");
  return a;
}

using Node = RefinedGrid::Node;
using Points = std::map<Node, Point>;

class Map {
 public:
  Map(const MapArguments& arguments, const VariedScene& varied)
      : a_(arguments),
        varied_(varied),
        stopping_{.enough = {.width = {}, .target = a_.target}},
        axes_{axis(a_.keys.at(0)), axis(a_.keys.at(1))},
        grid_(static_cast<int>(std::bit_ceil(static_cast<unsigned>(
            std::max<double>(RefinedGrid::kCoarsest, std::ceil(1 / a_.width)))))) {
    if (axes_[0].key == axes_[1].key) throw BadInput("map: both keys are " + axes_[0].key);
    refuse_beyond();
  }

  // As far as Ctrl-C and the time let it go: with all points that are whole. It looks at the
  // coarsest ones with few trials before, so that there is a line early. Shards, and who merges them,
  // take all the time that the line takes, as all must come to the same.
  void run() {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    const auto seconds = [&] {
      return std::chrono::duration<double>(Clock::now() - begin).count();
    };
    const auto stopped = [&] {
      return interrupted() || (!a_.job->store.get() && seconds() > a_.seconds);
    };
    for (auto nodes = grid_.next(); !nodes.empty(); nodes = grid_.next()) {
      const int before = cells();
      const bool look = before == 0 && !a_.job->store.get();
      for (const std::size_t trials : {look ? std::min(kLook, a_.trials) : a_.trials, a_.trials}) {
        run(nodes, trials, stopped);
        std::erase_if(nodes, [&](const Node& node) { return whole(node); });
        open_ = !nodes.empty();
        line_ = reached();
        if (cells() > before && !whole() && !stopped()) tell_so_far(seconds());
        if (!open_ || stopped()) break;
      }
      if (stopped()) return;
    }
  }

  const std::array<Axis, 2>& axes() const { return axes_; }
  const Points& points() const { return points_; }
  int asked_cells() const { return grid_.cells(); }
  // To how many parts of either range the line is known; 0: not even to kCoarsest.
  int cells() const { return line_ ? line_->cells() : 0; }
  bool whole() const { return cells() == asked_cells() && !open_; }
  // In units of the keys.
  std::vector<RefinedGrid::Line> contour() const {
    if (!line_) return {};
    std::vector<RefinedGrid::Line> lines = line_->contour();
    for (RefinedGrid::Line& line : lines)
      for (Eigen::Vector2d& p : line)
        p = {axes_[0].at(p.x() / cells()), axes_[1].at(p.y() / cells())};
    return lines;
  }
  std::size_t trials() const {
    std::size_t sum = 0;
    for (const auto& [node, point] : points_) sum += point.results.size();
    return sum;
  }
  std::size_t uniform_points() const {
    const auto side = static_cast<std::size_t>(line_ ? cells() : asked_cells()) + 1;
    return side * side;
  }
  // Points beside the contour of which the target is neither shown nor refuted.
  std::vector<const Point*> undecided() const {
    std::vector<const Point*> all;
    if (line_)
      for (const auto& [x, y] : line_->beside_contour()) {
        const int size = asked_cells() / cells();
        const Point& p = points_.at({size * x, size * y});
        if (p.scene && p.summary.target->kind == Verdict::undecided) all.push_back(&p);
      }
    return all;
  }
  std::size_t decided(Verdict::Kind kind) const {
    return static_cast<std::size_t>(
        std::count_if(points_.begin(), points_.end(), [&](const auto& p) {
          return (p.second.scene ? p.second.summary.target->kind : Verdict::refuted) == kind;
        }));
  }

 private:
  static constexpr std::size_t kLook = 30;  // trials

  // All of them that are not cut short.
  void run(const std::vector<Node>& nodes, std::size_t trials,
           const std::function<bool()>& stopped) {
    VariedArguments arguments = a_;
    arguments.trials = trials;
    Points tried;
    std::vector<Point*> wanted;
    for (const Node& node : nodes) wanted.push_back(&(tried[node] = point(node)));
    ferrule::run(arguments, varied_, stopping_, wanted, stopped);
    for (auto& [node, p] : tried) {
      if (p.scene && !stopping_.whole(p.results, trials)) continue;
      grid_.set(node, p.summary.successes > 0 ? p.summary.success_rate - a_.target : -a_.target);
      points_[node] = std::move(p);
    }
  }

  bool whole(const Node& node) const {
    const auto found = points_.find(node);
    return found != points_.end() &&
           (!found->second.scene || stopping_.whole(found->second.results, a_.trials));
  }

  std::string setting(std::size_t i, const std::string& value) const {
    return axes_[i].key + "=" + value;
  }

  // What a key must not have is said before the first trial.
  void refuse_beyond() const {
    std::vector<std::string> ranges;
    for (std::size_t i = 0; i < 2; ++i)
      ranges.push_back(setting(i, Json{{"uniform", {axes_[i].low, axes_[i].high}}}.dump()));
    varied_.with(ranges);
  }

  // The finest grid that has all its points: as if its width had been asked for.
  std::optional<RefinedGrid> reached() const {
    for (int cells = grid_.cells(); cells >= RefinedGrid::kCoarsest; cells /= 2)
      if (auto grid = grid_.coarser(cells)) return grid;
    return std::nullopt;
  }

  // The line while it gets finer, for people who wait: some of its points.
  void tell_so_far(double seconds) const {
    std::string text;
    for (const RefinedGrid::Line& line : contour())
      for (std::size_t k = 0; k < 5; ++k) {
        const Eigen::Vector2d& p = line[k * (line.size() - 1) / 4];
        text +=
            fmt::format("{}{:.4g} {:.4g}", k > 0 || text.empty() ? " " : "; and ", p.x(), p.y());
        if (k < 4) text += ",";
      }
    fmt::print(stderr, "after {:.0f} s known to 1/{}: {}\n", seconds, cells(),
               text.empty() ? "no line yet" : fmt::format("{:g} % along{}", 100 * a_.target, text));
  }

  Point point(const Node& node) const {
    Point p;
    std::vector<std::string> settings;
    for (std::size_t i = 0; i < 2; ++i) {
      const double value = axes_[i].at(static_cast<double>(node[i]) / asked_cells());
      p.values[axes_[i].key] = as_written(value);
      settings.push_back(setting(i, p.values[axes_[i].key].dump()));
    }
    try {
      p.scene = varied_.with(settings).scene;
    } catch (const BadInput&) {  // each of the numbers can be, but not these together
    }
    return p;
  }

  const MapArguments& a_;
  const VariedScene& varied_;
  StoppingArguments stopping_;
  std::array<Axis, 2> axes_;
  RefinedGrid grid_;
  std::optional<RefinedGrid> line_;  // as fine as it is known
  bool open_ = true;                 // points are left that were only looked at, or cut short
  Points points_;
};

const char* ended_by(const Map& map) {
  return map.whole() ? "width" : interrupted() ? "interrupt" : "time";
}

Json to_json(const MapArguments& a, const std::string& who, const Map& map) {
  Json keys = Json::array(), rows = Json::array(), contour = Json::array(), begins = Json::array();
  for (const Axis& axis : map.axes())
    keys.push_back({{"key", axis.key},
                    {"low", as_written(axis.low)},
                    {"high", as_written(axis.high)},
                    {"log", axis.log}});
  for (const auto& [node, point] : map.points()) {
    Json& row = rows.emplace_back(to_json(point));
    row["can_be"] = point.scene.has_value();
  }
  for (const RefinedGrid::Line& line : map.contour()) {
    begins.push_back(contour.size());
    for (const Eigen::Vector2d& p : line) contour.push_back({p.x(), p.y()});
  }
  return {{"controller", who},
          {"seed", a.seed},
          {"target", a.target},
          {"width", map.cells() > 0 ? Json(1.0 / map.cells()) : Json()},
          {"asked_width", 1.0 / map.asked_cells()},
          {"ended_by", ended_by(map)},
          {"keys", keys},
          {"rows", rows},
          {"contour", contour},
          {"contour_begins", begins},
          {"undecided", map.undecided().size()},
          {"trials", map.trials()},
          {"uniform_grid_points", map.uniform_points()},
          {"uniform_grid_trials", map.uniform_points() * a.trials}};
}

// What is known where there is no line.
std::string without_line(const MapArguments& a, const Map& map) {
  const std::size_t above = map.decided(Verdict::shown), below = map.decided(Verdict::refuted),
                    all = map.points().size();
  if (map.cells() > 0 && above + below > 1 && (above == 0 || below == 0))
    return fmt::format("{} than {:g} % inserted at all {} points that are decided, of {}\n",
                       above > 0 ? "more" : "less", 100 * a.target, above + below, all);
  return fmt::format(
      "no line: of {} points more than {:g} % inserted at {}, less at {}, and {} are not decided\n",
      all, 100 * a.target, above, below, all - above - below);
}

// How fine the line is, and why it is no finer.
std::string fineness(const MapArguments& a, const Map& map) {
  std::string text = map.cells() > 0 ? fmt::format("known to 1/{} of either range", map.cells())
                                     : "not known to any part of the ranges";
  if (!map.whole() && interrupted()) return text + fmt::format(": {} ended it there", stopped_by());
  if (!map.whole())
    text += fmt::format(": the time ended it there, --time {:g}s; with more it goes on, to 1/{}",
                        a.seconds, map.asked_cells());
  return text;
}

void tell(const MapArguments& a, const Map& map) {
  const auto& [x, y] = map.axes();
  const auto lines = map.contour();
  if (lines.empty())
    fmt::print("{}", without_line(a, map));
  else
    fmt::print("{:g} % inserted along\n{:>26} {:>26}\n", 100 * a.target, x.key, y.key);
  for (const auto& line : lines) {
    if (&line != &lines.front()) fmt::print("and\n");
    for (const Eigen::Vector2d& p : line) fmt::print("{:>26.6g} {:>26.6g}\n", p.x(), p.y());
  }
  const double share = static_cast<double>(map.trials()) /
                       (static_cast<double>(map.uniform_points()) * static_cast<double>(a.trials));
  fmt::print(
      "{}{}{} trials at {} points: {:.1f} % of the {} at {} points of a uniform grid as fine\n",
      fineness(a, map), map.whole() ? "; " : "\n", map.trials(), map.points().size(), 100 * share,
      map.uniform_points() * a.trials, map.uniform_points());
  const std::vector<const Point*> open = map.undecided();
  if (open.empty()) return;
  const auto [fewest, most] = std::minmax_element(
      open.begin(), open.end(),
      [](const Point* p, const Point* q) { return p->results.size() < q->results.size(); });
  const std::size_t from = (*fewest)->results.size(), to = (*most)->results.size();
  fmt::print(
      "points beside the line that are not decided: {}, by {} trials each; there it may run a "
      "little elsewhere\n",
      open.size(), from == to ? fmt::format("{}", to) : fmt::format("{} to {}", from, to));
}

int map_verb(const MapArguments& a) {
  const VariedScene varied(a);
  expect_place_for(a.plot);
  Map map(a, varied);
  const ChosenScene chosen = varied.with({});
  Provenance provenance = varied.provenance(chosen);
  if (a.output.text()) fmt::print("{}", provenance.head());
  std::fflush(stdout);  // the trials take long
  map.run();
  if (interrupted()) provenance.partial(fmt::format("{} points", map.points().size()));
  const Json json = to_json(a, varied.controller_name(), map);
  if (a.output.text()) {
    tell(a, map);
    fmt::print("{}", provenance.foot());
  } else {
    print_result(a.output, json, "rows", provenance);
  }
  std::fflush(stdout);  // before what may fail
  if (!a.plot.empty() && !map.points().empty()) write_plot(a.plot, map_plot(json));
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_map(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "map", "Over two numbers of the scene, where a controller inserts as often as it is to");
  auto a = std::make_shared<MapArguments>();
  a->trials = 1000;
  a->add_controller(*verb);
  verb->add_option("keys", a->keys, "Two keys of the scene, each with its range; :log is allowed")
      ->type_name("KEY=LOW..HIGH KEY=LOW..HIGH")
      ->expected(2)
      ->required();
  verb->add_option("--target", a->target, "Success rate along the line that is looked for")
      ->capture_default_str()
      ->check(number_between(1e-6, 0.999999));
  verb->add_option("--width", a->width, "How closely the line is to be known, as a part of a range")
      ->capture_default_str()
      ->check(number_between(1.0 / 1024, 1));
  a->add_options(*verb, run.job,
                 "At most at each point; fewer where the target is shown or refuted before", true);
  verb->add_option(
          "--time", a->seconds,
          "At most so long: 90s, 2min, 1h. The line gets finer until then. Shards take all "
          "the time that it takes")
      ->default_str("2min")
      ->type_name("TIME")
      ->excludes(verb->get_option("--shard"))
      ->transform(
          CLI::AsNumberWithUnit(std::map<std::string, double>{{"s", 1}, {"min", 60}, {"h", 3600}}))
      ->check(number_between(0.001, 1e9));
  add_plot(*verb, a->plot, "Draw it: success, and time, force and loss in quarters");
  add_output(*verb, a->output);
  add_examples(*verb, {"map controller.json ferrule.bore_diameter_um=125.5..127 "
                       "start.lateral_sd_um=2..30 --target 0.99 --plot map.svg",
                       "map constant-velocity limits.force_uN=5..500:log "
                       "start.lateral_sd_um=1..20 --scene bench --target 0.9 --json"});
  verb->callback([a, &run] { run.verb = [a] { return map_verb(*a); }; });
}

}  // namespace ferrule
