// ferrule sensitivity: which of the things that chance decides decides success, time, force, loss.
#include "controller/sensitivity.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/columns.hpp"
#include "app/varied_scene.hpp"
#include "app/verbs.hpp"
#include "sim/scene/drawn_numbers.hpp"

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

// As `value`, about its middle, but half as wide; a number, which is a width, half of it.
Json half_as_wide(const Json& value) {
  const auto half = [](double x) { return as_written(x / 2); };
  if (value.is_number()) return half(value.get<double>());
  Json narrow = value;
  Json& numbers = narrow.begin().value();
  if (value.contains("choice")) {
    double mean = 0;
    for (const Json& x : numbers) mean += x.get<double>() / static_cast<double>(numbers.size());
    for (Json& x : numbers) x = as_written((mean + x.get<double>()) / 2);
  } else if (value.contains("uniform")) {
    const double low = numbers[0], high = numbers[1];
    numbers = {as_written((3 * low + high) / 4), as_written((low + 3 * high) / 4)};
  } else {
    numbers[1] = half(numbers[1].get<double>());
  }
  return narrow;
}

// A width that chance draws from, halved.
Json half_of(const Json& width) {
  if (width.is_number()) return half_as_wide(width);
  Json half = width;
  for (Json& x : half.begin().value()) x = as_written(x.get<double>() / 2);
  if (width.contains("lognormal")) half["lognormal"][1] = width["lognormal"][1];
  return half;
}

// Settings with which what chance decides under this name is half as uncertain: half the standard
// deviation or width, about the same middle; of the sensor all its errors; half as many particles.
// Empty where that cannot be said.
std::vector<std::string> halved(const Scene& scene, const std::string& name) {
  const Json& document = scene.document();
  std::vector<std::string> settings;
  const auto set = [&](const std::string& key, const Json& value) {
    settings.push_back(key + "=" + value.dump());
  };
  const auto halve_width = [&](const std::string& key) {
    const Json::json_pointer at = pointer_to(key);
    if (document.contains(at) && !document.at(at).is_null()) set(key, half_of(document.at(at)));
  };
  if (name == "sensor")
    for (const char* key : {"noise_uN", "bias_uN", "bias_walk_uN_sqrt_s", "gain_error",
                            "cross_talk", "temperature_drift_uN_K", "vibration_uN"})
      halve_width("sensor." + std::string(key));
  if (name == "laws.particle") halve_width("laws.particle.number");
  for (const DrawnNumber& number : scene.drawn) {
    if (number.name() != name) continue;
    const Json::json_pointer at = pointer_to(number.key);
    if (!number.shared.empty()) {
      if (settings.empty()) halve_width(number.shared);
    } else if (document.contains(at)) {
      if (Distribution::read(document.at(at))) set(number.key, half_as_wide(document.at(at)));
    } else {  // implied: a direction, or normal within three standard deviations
      const auto ends = number.distribution.extremes();
      const double sd = (ends[1] - ends[0]) / 6;
      set(number.key, half_as_wide(number.key.ends_with("_deg")
                                       ? Json{{"uniform", {ends[0], ends[1]}}}
                                       : Json{{"normal", {number.distribution.centre(), sd}}}));
    }
  }
  return settings;
}

// A result with something half as uncertain, on the same trials, and by how much it changed.
struct Halved {
  double value = NAN, change = NAN;
  Interval interval{NAN, NAN};  // 95 %
};

Halved halved_success(const std::vector<TrialResult>& before,
                      const std::vector<TrialResult>& after) {
  std::vector<TrialResult> a, b;  // of the trials that are feasible in both
  for (std::size_t k = 0; k < std::min(before.size(), after.size()); ++k)
    if (before[k].outcome != Outcome::infeasible && after[k].outcome != Outcome::infeasible) {
      a.push_back(after[k]);
      b.push_back(before[k]);
    }
  if (a.empty()) return {};
  const Comparison c = compare(a, b);
  return {summarise(after).success_rate, c.difference, c.interval};
}

// Medians; the change in the trials that have both.
Halved halved_median(const std::vector<double>& before, const std::vector<double>& after) {
  std::vector<double> changes, values;
  for (std::size_t k = 0; k < after.size(); ++k) {
    if (!std::isnan(after[k])) values.push_back(after[k]);
    if (!std::isnan(after[k] - before[k])) changes.push_back(after[k] - before[k]);
  }
  return {quantile(values, 0.5), quantile(changes, 0.5), median_interval(changes)};
}

struct Decided {
  std::string key;
  struct Of {
    SobolIndex first, total;
    Halved halved;
  };
  std::array<Of, kQuantities.size()> of;
};

// Of the first `count` trials.
std::vector<double> values(const Quantity& quantity, const std::vector<TrialResult>& results,
                           std::size_t count) {
  std::vector<double> all;
  for (std::size_t k = 0; k < count; ++k) all.push_back(quantity.of(results[k]));
  return all;
}

// What is run: as it is; each of the keys drawn again; each half as uncertain, where that can be;
// all drawn again.
struct Runs {
  std::vector<std::string> keys;
  Point as_it_is, all_again;
  std::vector<Point> again, half;
};

Runs runs_of(const VariedScene& varied, const Scene& scene) {
  Runs r;
  r.keys = drawn_in(scene);
  r.as_it_is.scene = r.all_again.scene = scene;
  for (const std::string& key : r.keys) {
    r.again.push_back(r.as_it_is);
    r.again.back().redrawn = key;
    Point& half = r.half.emplace_back();
    const std::vector<std::string> settings = halved(scene, key);
    if (settings.empty()) continue;
    try {
      half.scene = varied.with(settings).scene;
    } catch (const BadInput&) {  // a choice between what cannot be in the middle
    }
  }
  return r;
}

void run_all(const VariedArguments& a, const VariedScene& varied, Runs& r) {
  std::vector<Point*> all = {&r.as_it_is};
  for (Point& point : r.again) all.push_back(&point);
  for (Point& point : r.half) all.push_back(&point);
  run(a, varied, {}, all);
  VariedArguments others = a;
  others.seed = seed_of("all", "all", a.seed);  // with which each alone is drawn again
  run(others, varied, {}, {&r.all_again});
}

std::vector<Decided> decided(const Runs& r, std::uint64_t seed) {
  std::vector<Decided> all;
  for (std::size_t i = 0; i < r.keys.size(); ++i) {
    const auto &again = r.again[i].results, &half = r.half[i].results;
    Decided& one = all.emplace_back();
    one.key = r.keys[i];
    const std::size_t two = std::min(r.as_it_is.results.size(), again.size()),
                      three = std::min(two, r.all_again.results.size()),
                      both = std::min(r.as_it_is.results.size(), half.size());
    for (std::size_t q = 0; q < kQuantities.size(); ++q) {
      const auto of = [&](const std::vector<TrialResult>& results, std::size_t count) {
        return values(kQuantities[q], results, count);
      };
      one.of[q] = {first_order_index(of(r.as_it_is.results, three), of(again, three),
                                     of(r.all_again.results, three), seed),
                   total_index(of(r.as_it_is.results, two), of(again, two), seed),
                   q == 0 ? halved_success(r.as_it_is.results, half)
                          : halved_median(of(r.as_it_is.results, both), of(half, both))};
    }
  }
  const auto share = [](const Decided& d) {
    return std::isnan(d.of[0].total.index) ? -1 : d.of[0].total.index;
  };
  std::stable_sort(all.begin(), all.end(),
                   [&](const Decided& a, const Decided& b) { return share(a) > share(b); });
  return all;
}

Json between(const Interval& i, const char* format) {
  if (std::isnan(i.low)) return {};
  return fmt::format(fmt::runtime(format), i.low, i.high);
}

Columns<Decided> success_columns() {
  using D = const Decided&;
  return {
      {"", "decided by chance", "<30", [](D d) { return Json(d.key); }},
      {"", "first order", ">11.2f", [](D d) { return Json(d.of[0].first.index); }},
      {"", "95 %", ">12", [](D d) { return between(d.of[0].first.interval, "{:.2f}..{:.2f}"); }},
      {"", "total", ">8.2f", [](D d) { return Json(d.of[0].total.index); }},
      {"", "95 %", ">12", [](D d) { return between(d.of[0].total.interval, "{:.2f}..{:.2f}"); }},
      {"", "half as uncertain [%]", ">21.1f", [](D d) { return Json(100 * d.of[0].halved.value); }},
      {"", "gained", ">7.1f", [](D d) { return Json(100 * d.of[0].halved.change); }},
      {"", "95 %", ">13", [](D d) {
         const Interval& i = d.of[0].halved.interval;
         return between({100 * i.low, 100 * i.high}, "{:+.1f}..{:+.1f}");
       }}};
}

// First order and total of the others, and what they change by.
Columns<Decided> other_columns() {
  Columns<Decided> table = {
      {"", "decided by chance", "<30", [](const Decided& d) { return Json(d.key); }}};
  constexpr std::array headings = {"time [s]: 1st", "peak [uN]: 1st", "loss [dB]: 1st"};
  for (std::size_t q = 1; q < kQuantities.size(); ++q) {
    table.push_back({"", headings[q - 1], ">14.2f",
                     [q](const Decided& d) { return Json(d.of[q].first.index); }});
    table.push_back(
        {"", "total", ">6.2f", [q](const Decided& d) { return Json(d.of[q].total.index); }});
    table.push_back({"", "halved", q == 3 ? ">+8.4f" : ">+8.2f",
                     [q](const Decided& d) { return Json(d.of[q].halved.change); }});
  }
  return table;
}

Json rows(const std::vector<Decided>& all) {
  Json rows = Json::array();
  for (std::size_t q = 0; q < kQuantities.size(); ++q)
    for (const Decided& d : all) {
      const auto& [first, total, halved] = d.of[q];
      rows.push_back({{"key", d.key},
                      {"first", number_or_null(first.index)},
                      {"first_low", number_or_null(first.interval.low)},
                      {"first_high", number_or_null(first.interval.high)},
                      {"total", number_or_null(total.index)},
                      {"low", number_or_null(total.interval.low)},
                      {"high", number_or_null(total.interval.high)},
                      {"interaction", number_or_null(std::max(total.index - first.index, 0.0))},
                      {"halved", number_or_null(halved.value)},
                      {"halved_change", number_or_null(halved.change)},
                      {"halved_change_low", number_or_null(halved.interval.low)},
                      {"halved_change_high", number_or_null(halved.interval.high)},
                      {"of", kQuantities[q].name}});
    }
  return rows;
}

// The part of the variance of success that no thing makes by itself; NaN where that is not known.
double interaction(const std::vector<Decided>& all) {
  double alone = 0;
  for (const Decided& d : all) alone += d.of[0].first.index;
  return std::clamp(1 - alone, 0.0, 1.0);
}

void tell(const VariedScene& varied, const CampaignSummary& s, const std::vector<Decided>& found) {
  fmt::print("{}: {} of {} inserted, {} %, peak force {} uN (median)\n", varied.controller_name(),
             s.successes, s.feasible, number_or("-", "{:.1f}", 100 * s.success_rate),
             number_or("-", "{:.4g}", 1e6 * s.peak_force.median));
  print_table(success_columns(), found);
  print_table(other_columns(), found);
  fmt::print(
      "Sobol indices. First order: the share of the variance that it makes by itself; the rest of "
      "success, {} %,\nis interaction. Total: with all that it does together with others, so that "
      "totals are no shares of a whole.\nHalf as uncertain: success on the same trials with half "
      "the standard deviation or width, and halved: the\nmedian change of the others. {} trials, "
      "each again with each drawn again, halved, and all drawn again;\ntime and loss: of trials "
      "that insert each time; -: all are the same\n",
      number_or("-", "{:.0f}", 100 * interaction(found)), s.trials);
}

int sensitivity_verb(const VariedArguments& a) {
  const VariedScene varied(a);
  const ChosenScene chosen = varied.with({});
  Runs runs = runs_of(varied, chosen.scene);
  if (runs.keys.empty())
    throw BadInput(chosen.scene.name +
                   ": nothing in it is decided by chance; draw numbers with --set, as in --set "
                   "ferrule.bore_diameter_um=126+-0.3");
  Provenance provenance = varied.provenance(chosen);
  if (a.output.text()) fmt::print("{}", provenance.head());
  std::fflush(stdout);  // the trials take long
  run_all(a, varied, runs);
  if (interrupted()) {
    const auto whole = std::count_if(runs.again.begin(), runs.again.end(), [&](const Point& point) {
      return point.results.size() == a.trials;
    });
    provenance.partial(fmt::format("{} of {} that are decided by chance", whole, runs.keys.size()));
  }
  const std::vector<Decided> found = decided(runs, a.seed);
  const CampaignSummary s = summarise(runs.as_it_is.results);
  if (a.output.text()) {
    tell(varied, s, found);
    fmt::print("{}", provenance.foot());
  } else {
    print_result(a.output,
                 {{"controller", varied.controller_name()},
                  {"seed", a.seed},
                  {"trials", s.trials},
                  {"success_rate", number_or_null(s.success_rate)},
                  {"interaction", number_or_null(interaction(found))},
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
  a->add_options(*verb, run.job, "How many, each again twice for everything that is drawn");
  add_output(*verb, a->output);
  add_examples(*verb, {"sensitivity controller.json --scene tolerance",
                       "sensitivity controller.json --set fibre.diameter_um=125+-0.7 --set "
                       "ferrule.bore_diameter_um=126+1/-0 --trials 4000"});
  verb->callback([a, &run] { run.verb = [a] { return sensitivity_verb(*a); }; });
}

}  // namespace ferrule
