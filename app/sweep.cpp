// ferrule sweep: success, time, force and loss of a controller over numbers of the scene.
#include <fmt/format.h>

#include <algorithm>

#include "app/columns.hpp"
#include "app/given_controller.hpp"
#include "app/plot.hpp"
#include "app/stopping.hpp"
#include "app/trained.hpp"
#include "app/verb.hpp"
#include "controller/campaign_table.hpp"
#include "controller/controller.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

constexpr const char* kStraight = "constant-velocity";

struct SweepArguments {
  SceneArguments scene;
  std::string controller, plot;
  std::vector<std::string> keys;
  std::size_t trials = 200;
  std::uint64_t seed = 7;
  int threads = 0;
  bool other_scaling = false;
  StoppingArguments stopping;
  Output output;
};

// KEY=a,b,c.
struct Swept {
  std::string key;
  std::vector<std::string> values;  // as --set takes them
};

struct Point {
  std::vector<std::string> values;  // of the keys
  ChosenScene chosen;
  std::vector<TrialResult> results{};
  CampaignSummary summary{};
};

Swept swept(const std::string& text) {
  const auto equals = text.find('=');
  if (equals == text.npos || equals == 0 || equals + 1 == text.size())
    throw BadInput("sweep " + text + ": must be KEY=a,b,c or KEY=from:to:count[:log]");
  Swept s{text.substr(0, equals), {}};
  const std::string list = text.substr(equals + 1);
  if (list.find(':') != list.npos) {
    for (const double value : parse_range(list, s.key))
      s.values.push_back(as_written(value).dump());
  } else {
    s.values = CLI::detail::split(list, ',');
  }
  return s;
}

// Every value of each with every one of the others; the last key changes fastest.
std::vector<std::vector<std::string>> combinations(const std::vector<Swept>& all) {
  std::vector<std::vector<std::string>> points = {{}};
  for (const Swept& s : all) {
    std::vector<std::vector<std::string>> longer;
    for (const auto& point : points)
      for (const std::string& value : s.values) {
        longer.push_back(point);
        longer.back().push_back(value);
      }
    points = std::move(longer);
  }
  return points;
}

// All scenes, before the first trial: what is refused is refused at once.
std::vector<Point> points_of(const SweepArguments& a, const std::vector<Swept>& all,
                             const BroughtScene& brought) {
  std::vector<Point> points;
  for (const std::vector<std::string>& values : combinations(all)) {
    SceneArguments scene = a.scene;
    for (std::size_t i = 0; i < all.size(); ++i)
      scene.settings.push_back(all[i].key + "=" + values[i]);
    points.push_back({values, scene.choose(brought)});
  }
  return points;
}

Json value_in(const Point& point, const std::string& key) {
  return point.chosen.scene.document.at(pointer_to(key));
}

Columns<Point> columns(const std::vector<Swept>& all) {
  Columns<Point> table;
  for (std::size_t i = 0; i < all.size(); ++i)
    table.push_back(
        {"", all[i].key.c_str(), ">18", [i](const Point& p) { return Json(p.values[i]); }});
  const auto add = [&](const char* heading, const char* format, auto cell) {
    table.push_back({"", heading, format, [cell](const Point& p) { return cell(p.summary); }});
  };
  using S = const CampaignSummary&;
  add("trials", ">7", [](S s) { return Json(s.trials); });
  add("inserted [%]", ">12.1f", [](S s) { return Json(100 * s.success_rate); });
  add("from", ">6.1f", [](S s) { return Json(100 * s.wilson.low); });
  add("to, 95 %", ">8.1f", [](S s) { return Json(100 * s.wilson.high); });
  add("infeasible", ">10", [](S s) { return Json(s.trials - s.feasible); });
  add("time [s]", ">9.2f", [](S s) { return Json(s.time.median); });
  add("peak [uN]", ">9.2f", [](S s) { return Json(1e6 * s.peak_force.median); });
  add("loss [dB]", ">9.4f", [](S s) { return Json(s.loss_dB.median); });
  add("mated", ">7.3f", [](S s) { return Json(s.mated ? s.mated->untuned.mean_dB : NAN); });
  add("97 %", ">6.3f", [](S s) { return Json(s.mated ? s.mated->untuned.p97_dB : NAN); });
  return table;
}

// Over the first key, a line for each combination of the others.
Plot plot(const std::vector<Swept>& all, const std::vector<Point>& points, const std::string& who) {
  Axes success, force, loss;
  success.y_label = "inserted [%]";
  force.y_label = "peak force [uN]";
  loss.y_label = "joint loss [dB]";
  success.y_low = 0;
  success.y_high = 100;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Point& point = points[k];
    std::string name;
    for (std::size_t i = 1; i < all.size(); ++i)
      name += (i > 1 ? ", " : "") + all[i].key + " " + point.values[i];
    const Json value = value_in(point, all[0].key);
    const auto drawn = Distribution::read(value);
    const double x = drawn               ? drawn->centre()
                     : value.is_number() ? value.get<double>()
                                         : static_cast<double>(k);
    const auto add = [&](Axes& axes, double y) {
      axes.x_label = all[0].key;
      auto series = std::find_if(axes.series.begin(), axes.series.end(),
                                 [&](const Series& s) { return s.name == name; });
      if (series == axes.series.end())
        series = axes.series.insert(axes.series.end(), {name, {}, {}, Series::points_on_line});
      series->x.push_back(x);
      series->y.push_back(y);
    };
    add(success, 100 * point.summary.success_rate);
    add(force, 1e6 * point.summary.peak_force.median);
    add(loss, point.summary.loss_dB.median);
  }
  return {"Trials of " + who, {success, force, loss}, 860, 300};
}

Json to_json(const SweepArguments& a, const std::string& who, const std::vector<Swept>& all,
             const std::vector<Point>& points) {
  return {
      {"controller", who}, {"seed", a.seed}, {"rows", json_list(points, [&](const Point& point) {
                                                Json row = Json::object();
                                                for (const Swept& s : all)
                                                  row[s.key] = value_in(point, s.key);
                                                row.update(ferrule::to_json(point.summary));
                                                return row;
                                              })}};
}

// In that scene; the straight push is as fast as it may be there.
MakeController in_scene(const std::optional<GivenController>& given, const Scene& scene) {
  if (given) return given->make;
  return controller_maker(ConstantVelocity(scene_scaling(scene).motion * scene.limits.speed));
}

void run(const SweepArguments& a, const std::optional<GivenController>& given,
         std::vector<Point>& points) {
  for (std::size_t k = 0; k < points.size() && !interrupted(); ++k) {
    Point& point = points[k];
    const Scene& scene = point.chosen.scene;
    point.results =
        run_campaign(scene, in_scene(given, scene), a.seed, a.trials, a.threads,
                     Progress(fmt::format("point {} of {}", k + 1, points.size()), a.trials),
                     interrupted, when(a.stopping.enough));
    point.summary = a.stopping.summary(point.results);
    point.summary.mated = mated(scene.joint, point.results, a.seed);
  }
}

int sweep_verb(const SweepArguments& a) {
  const bool file = a.controller != kStraight;
  std::vector<Swept> all;
  for (const std::string& text : a.keys) all.push_back(swept(text));
  std::optional<GivenController> given;
  BroughtScene brought;
  if (file) {
    given = given_file(a.controller, {}, a.seed);
    if (given->file) brought = brought_by(trained_on(*given->file), a.controller);
  }
  expect_place_for(a.plot);
  std::vector<Point> points = points_of(a, all, brought);
  Provenance provenance;
  provenance.in(a.scene.choose(brought)).seed("trials", a.seed);
  if (file) provenance.read(a.controller);
  if (given && given->file)
    for (const Point& point : points)
      refuse_other_scaling(trained_on(*given->file).scaling, a.controller, point.chosen.scene,
                           a.other_scaling);
  if (a.output.text()) fmt::print("{}", provenance.head());
  std::fflush(stdout);  // the trials take long
  run(a, given, points);
  if (interrupted()) {
    const auto whole = [&](const Point& p) { return a.stopping.whole(p.results, a.trials); };
    const auto count = std::count_if(points.begin(), points.end(), whole);
    provenance.partial(fmt::format("{} of {} points", count, points.size()));
    std::erase_if(points, [&](const Point& p) { return !whole(p); });
  }
  const std::string who = printable(a.controller);
  if (a.output.text()) {
    print_table(columns(all), points);
    fmt::print(
        "the same {}{} trials at each point; time and loss: medians of the inserted; peak "
        "force: median of all;\nmated: mean and 97 % of the losses [dB] of 10,000 pairs of "
        "the inserted\n{}",
        when(a.stopping.enough) ? "at most " : "", a.trials, provenance.foot());
  } else {
    print_result(a.output, to_json(a, who, all, points), "rows", provenance);
  }
  std::fflush(stdout);  // before what may fail
  if (!a.plot.empty() && !points.empty()) write_plot(a.plot, plot(all, points, who));
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_sweep(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "sweep", "Success, time, force and loss of a controller over numbers of the scene");
  auto a = std::make_shared<SweepArguments>();
  verb->add_option("controller", a->controller,
                   std::string("Controller file, or TorchScript; or ") + kStraight)
      ->type_name("FILE.json|FILE.pt")
      ->required();
  verb->add_option(
          "keys", a->keys,
          "Values of a key, as --set takes them: a,b,c, or of numbers from:to:count[:log]; "
          "with several keys all combinations")
      ->type_name("KEY=VALUES")
      ->required();
  a->scene.add_to(*verb, "that of the controller's training, or demo");
  add_other_scaling(*verb, a->other_scaling);
  verb->add_option("--trials", a->trials, "At each point")
      ->capture_default_str()
      ->check(whole_number(1, 100000000));
  a->stopping.add_to(*verb);
  add_seed(*verb, a->seed, "Seed of the trials, the same at each point");
  add_threads(*verb, a->threads);
  add_plot(*verb, a->plot, "Draw it over the first key, a line for each combination of the others");
  add_output(*verb, a->output);
  add_examples(*verb, {"sweep controller.json ferrule.bore_diameter_um=125.5,126,127",
                       "sweep controller.json ferrule.bore_diameter_um=125.5+1/-0,126+1/-0 "
                       "start.lateral_sd_um=5,10,15 --plot sweep.svg",
                       "sweep constant-velocity limits.force_uN=5:80:5:log --scene bench --csv"});
  verb->callback([a, &run] { run = [a] { return sweep_verb(*a); }; });
}

}  // namespace ferrule
