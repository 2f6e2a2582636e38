// ferrule sensitivity: which of the things that chance decides decides success, time, force, loss.
#include "controller/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/columns.hpp"
#include "app/varied_scene.hpp"

namespace ferrule {
namespace {

// A result of a trial; NaN where it has none.
struct Quantity {
  const char* name;
  double (*of)(const TrialResult&);
};
double of_inserted(const TrialResult& r, double value) {
  return r.outcome == Outcome::inserted ? value : NAN;
}
constexpr std::array kQuantities = {
    Quantity{"success",
             [](const TrialResult& r) -> double {
               return r.outcome == Outcome::infeasible ? NAN : r.outcome == Outcome::inserted;
             }},
    Quantity{"time_s", [](const TrialResult& r) { return of_inserted(r, r.summary.time); }},
    Quantity{"peak_force_uN",
             [](const TrialResult& r) {
               return r.outcome == Outcome::infeasible ? NAN : 1e6 * r.summary.peak_force;
             }},
    Quantity{"loss_dB", [](const TrialResult& r) { return of_inserted(r, r.loss_dB); }}};

// What chance decides in a scene.
std::vector<std::string> drawn_in(const Scene& scene) {
  std::vector<std::string> keys;
  for (const DrawnNumber& number : scene.drawn)
    if (std::find(keys.begin(), keys.end(), number.name()) == keys.end())
      keys.push_back(number.name());
  const auto& particle = scene.parameters.laws.particle;
  const std::array there = {!scene.sensor.ideal(),
                            particle.has_value() && std::isnan(particle->height)};
  for (std::size_t i = 0; i < there.size(); ++i)
    if (there[i]) keys.emplace_back(kDrawnBesides[i]);
  return keys;
}

struct Decided {
  std::string key;
  std::array<TotalIndex, kQuantities.size()> index;
};

// Of the first `count` trials.
std::vector<double> values(const Quantity& quantity, const std::vector<TrialResult>& results,
                           std::size_t count) {
  std::vector<double> all;
  for (std::size_t k = 0; k < count; ++k) all.push_back(quantity.of(results[k]));
  return all;
}

// The points: as it is, then with each of the keys drawn again; of the trials that both have.
std::vector<Decided> decided(const std::vector<std::string>& keys, const std::vector<Point>& points,
                             std::uint64_t seed) {
  std::vector<Decided> all;
  const std::vector<TrialResult>& as_it_is = points[0].results;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::vector<TrialResult>& again = points[i + 1].results;
    const std::size_t count = std::min(as_it_is.size(), again.size());
    Decided& one = all.emplace_back();
    one.key = keys[i];
    for (std::size_t q = 0; q < kQuantities.size(); ++q)
      one.index[q] = total_index(values(kQuantities[q], as_it_is, count),
                                 values(kQuantities[q], again, count), seed);
  }
  const auto share = [](const Decided& d) {
    return std::isnan(d.index[0].total) ? -1 : d.index[0].total;
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Decided& a, const Decided& b) { return share(a) > share(b); });
  return all;
}

Columns<Decided> columns() {
  Columns<Decided> table = {
      {"", "decided by chance", "<30", [](const Decided& d) { return Json(d.key); }}};
  constexpr std::array headings = {"success", "time", "peak force", "loss"};
  for (std::size_t q = 0; q < kQuantities.size(); ++q) {
    table.push_back(
        {"", headings[q], ">10.2f", [q](const Decided& d) { return Json(d.index[q].total); }});
    table.push_back(
        {"", "95 %", ">12", [q](const Decided& d) {
           const TotalIndex& t = d.index[q];
           return std::isnan(t.total)
                      ? Json()
                      : Json(fmt::format("{:.2f}..{:.2f}", t.interval.low, t.interval.high));
         }});
  }
  return table;
}

Json rows(const std::vector<Decided>& all) {
  Json rows = Json::array();
  for (std::size_t q = 0; q < kQuantities.size(); ++q)
    for (const Decided& d : all)
      rows.push_back({{"key", d.key},
                      {"total", number_or_null(d.index[q].total)},
                      {"low", number_or_null(d.index[q].interval.low)},
                      {"high", number_or_null(d.index[q].interval.high)},
                      {"of", kQuantities[q].name}});
  return rows;
}

int sensitivity_verb(const VariedArguments& a) {
  const VariedScene varied(a);
  const ChosenScene chosen = varied.with({});
  const std::vector<std::string> keys = drawn_in(chosen.scene);
  if (keys.empty())
    throw BadInput(chosen.scene.name +
                   ": nothing in it is decided by chance; draw numbers with --set, as in --set "
                   "ferrule.bore_diameter_um=126+-0.3");
  std::vector<Point> points(1);
  points[0].scene = chosen.scene;
  for (const std::string& key : keys) {
    points.push_back(points[0]);
    points.back().scene->redrawn = key;
  }
  Provenance provenance = varied.provenance(chosen);
  if (a.output.text()) fmt::print("{}", provenance.head());
  std::fflush(stdout);  // the trials take long
  std::vector<Point*> all;
  for (Point& point : points) all.push_back(&point);
  run(a, varied, {}, all);
  if (interrupted()) {
    const auto whole = std::count_if(points.begin() + 1, points.end(), [&](const Point& point) {
      return point.results.size() == a.trials;
    });
    provenance.partial(fmt::format("{} of {} that are decided by chance", whole, keys.size()));
  }
  const std::vector<Decided> found = decided(keys, points, a.seed);
  const CampaignSummary s = summarise(points[0].results);
  if (a.output.text()) {
    fmt::print("{}: {} of {} inserted, peak force {} uN (median)\n", varied.controller_name(),
               s.successes, s.feasible, number_or("-", "{:.4g}", 1e6 * s.peak_force.median));
    print_table(columns(), found);
    fmt::print(
        "total Sobol indices: the share of the variance that would be left if all others were "
        "known; {} trials,\neach again with each drawn again; time and loss: of trials that insert "
        "both times; -: all are the same\n{}",
        s.trials, provenance.foot());
  } else {
    print_result(a.output,
                 {{"controller", varied.controller_name()},
                  {"seed", a.seed},
                  {"trials", s.trials},
                  {"success_rate", number_or_null(s.success_rate)},
                  {"rows", rows(found)}},
                 "rows", provenance);
  }
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_sensitivity(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "sensitivity", "Which of the things that chance decides decides success, time, force, loss");
  auto a = std::make_shared<VariedArguments>();
  a->trials = 1000;
  a->add_controller(*verb);
  a->add_options(*verb, "How many, each again for everything that is drawn");
  add_output(*verb, a->output);
  add_examples(*verb, {"sensitivity controller.json --scene tolerance",
                       "sensitivity controller.json --set fibre.diameter_um=125+-0.7 --set "
                       "ferrule.bore_diameter_um=126+1/-0 --trials 4000"});
  verb->callback([a, &run] { run = [a] { return sensitivity_verb(*a); }; });
}

}  // namespace ferrule
