// ferrule sweep: success, time, force and loss of a controller over numbers of the scene.
#include <fmt/format.h>

#include <algorithm>

#include "app/answers.hpp"
#include "app/best_rows.hpp"
#include "app/columns.hpp"
#include "app/stopping.hpp"
#include "app/validators.hpp"
#include "app/varied_plots.hpp"
#include "app/varied_scene.hpp"
#include "app/verbs.hpp"
#include "controller/campaign_table.hpp"

namespace ferrule {
namespace {

struct SweepArguments : VariedArguments {
  std::vector<std::string> keys;
  std::string plot;
  StoppingArguments stopping;
  PreferArguments prefer;
};

// KEY=a,b,c.
struct Swept {
  std::string key;
  std::vector<std::string> values;  // as --set takes them
};

struct SweptPoint : Point {
  std::vector<std::string> written;  // the values of the keys
  Json price{};                      // null: none is stated
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
std::vector<SweptPoint> points_of(const std::vector<Swept>& all, const VariedScene& varied) {
  std::vector<SweptPoint> points;
  for (const std::vector<std::string>& values : combinations(all)) {
    std::vector<std::string> settings;
    for (std::size_t i = 0; i < all.size(); ++i) settings.push_back(all[i].key + "=" + values[i]);
    SweptPoint& point = points.emplace_back();
    point.written = values;
    point.scene = varied.with(settings).scene;
    for (const Swept& s : all) point.values[s.key] = point.scene->document().at(pointer_to(s.key));
  }
  return points;
}

// "C (B to C)".
std::string grade_cell(const MatedPairs& pairs) {
  if (pairs.pairs == 0) return "-";
  const char* grade = connector_grade(pairs);
  return (grade ? grade : "none") + allowed_grades_text(pairs);
}

Columns<SweptPoint> columns(const std::vector<Swept>& all) {
  Columns<SweptPoint> table;
  for (std::size_t i = 0; i < all.size(); ++i)
    table.push_back(
        {"", all[i].key.c_str(), ">18", [i](const SweptPoint& p) { return Json(p.written[i]); }});
  const auto add = [&](const char* heading, const char* format, auto cell) {
    table.push_back({"", heading, format, [cell](const SweptPoint& p) { return cell(p.summary); }});
  };
  using S = const CampaignSummary&;
  add_success_columns(add);
  add("infeasible", ">10", [](S s) { return Json(s.trials - s.feasible); });
  add("time [s]", ">9.2f", [](S s) { return Json(s.time.median); });
  add("peak [uN]", ">9.2f", [](S s) { return Json(1e6 * s.peak_force.median); });
  add("mated", ">7.3f", [](S s) { return Json(s.mated ? s.mated->untuned.mean_dB : NAN); });
  add("97 %", ">6.3f", [](S s) { return Json(s.mated ? s.mated->untuned.p97_dB : NAN); });
  add("grade", ">16", [](S s) { return Json(s.mated ? grade_cell(s.mated->untuned) : "-"); });
  return table;
}

Json keys_of(const std::vector<Swept>& all) {
  return json_list(all, [](const Swept& s) { return s.key; });
}

Json to_json(const SweepArguments& a, const std::string& who, const std::vector<Swept>& all,
             const std::vector<SweptPoint>& points) {
  return {{"controller", who},
          {"seed", a.seed},
          {"keys", keys_of(all)},
          {"rows", json_list(points, [](const SweptPoint& point) {
             Json row = to_json(point);
             if (!point.price.is_null()) row["price"] = point.price;
             return row;
           })}};
}

// Of all points, before the first trial. Throws BadInput.
void put_prices(const std::vector<Swept>& all, const PreferArguments& prefer,
                std::vector<SweptPoint>& points) {
  Json result = {{"keys", keys_of(all)}, {"rows", json_list(points, [](const SweptPoint& point) {
                                            return Json{{"values", point.values}};
                                          })}};
  prefer.put_into(result);
  for (std::size_t k = 0; k < points.size(); ++k)
    points[k].price = result.at("rows")[k].value("price", Json());
}

// What the table is of, and what it answers.
void tell(const SweepArguments& a, const Json& json) {
  fmt::print(
      "the same {}{} trials at each point; time: median of the inserted; peak force: median of "
      "all;\nmated: mean and 97 % of the losses [dB] of 10,000 pairs of the inserted, with their "
      "grade and those that 95 % intervals allow\n",
      when(a.stopping.enough) ? "at most " : "", a.trials);
  for (const std::string& line : answers().at("sweep")(json).lines)
    fmt::print("{}\n", printable(line, 1000));
}

int sweep_verb(const SweepArguments& a) {
  std::vector<Swept> all;
  for (const std::string& text : a.keys) all.push_back(swept(text));
  const VariedScene varied(a);
  expect_place_for(a.plot);
  std::vector<SweptPoint> points = points_of(all, varied);
  const ChosenScene chosen = varied.with({});
  put_prices(all, a.prefer, points);
  Provenance provenance = varied.provenance(chosen);
  if (a.output.text()) fmt::print("{}", provenance.head());
  std::fflush(stdout);  // the trials take long
  std::vector<Point*> to_run;
  for (SweptPoint& point : points) to_run.push_back(&point);
  run(a, varied, a.stopping, to_run);
  if (interrupted()) {
    const auto whole = [&](const Point& p) { return a.stopping.whole(p.results, a.trials); };
    const auto count = std::count_if(points.begin(), points.end(), whole);
    provenance.partial(fmt::format("{} of {} points", count, points.size()));
    std::erase_if(points, [&](const Point& p) { return !whole(p); });
  }
  Json json = to_json(a, varied.controller_name(), all, points);
  if (!a.prefer.prefer.empty()) json["prefer"] = a.prefer.prefer;
  if (a.output.text()) {
    print_table(columns(all), points);
    tell(a, json);
    fmt::print("{}", provenance.foot());
  } else {
    print_result(a.output, json, "rows", provenance);
  }
  std::fflush(stdout);  // before what may fail
  if (!a.plot.empty() && !points.empty()) write_plot(a.plot, sweep_plot(json));
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_sweep(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "sweep", "Success, time, force and loss of a controller over numbers of the scene");
  auto a = std::make_shared<SweepArguments>();
  a->trials = 200;
  a->add_controller(*verb);
  verb->add_option(
          "keys", a->keys,
          "Values of a key, as --set takes them: a,b,c, or of numbers from:to:count[:log]; "
          "with several keys all combinations")
      ->type_name("KEY=VALUES")
      ->required();
  a->add_options(*verb, run.job, "At each point");
  a->stopping.add_to(*verb);
  a->prefer.add_to(*verb);
  add_plot(*verb, a->plot, "Draw it over the first key, a line for each combination of the others");
  add_output(*verb, a->output);
  add_examples(*verb, {"sweep controller.json ferrule.bore_diameter_um=125.5,126,127",
                       "sweep controller.json ferrule.bore_diameter_um=125.5+1/-0,126+1/-0 "
                       "start.lateral_sd_um=5,10,15 --plot sweep.svg",
                       "sweep constant-velocity limits.force_uN=5:80:5:log --scene bench --csv"});
  verb->callback([a, &run] { run.verb = [a] { return sweep_verb(*a); }; });
}

}  // namespace ferrule
