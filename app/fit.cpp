// ferrule fit: a controller from demonstrations.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <filesystem>

#include "app/interrupt.hpp"
#include "app/law_plot.hpp"
#include "app/output.hpp"
#include "app/trained.hpp"
#include "app/training_plot.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "controller/statistics.hpp"
#include "learn/candidates.hpp"
#include "learn/fit_warnings.hpp"

namespace ferrule {
namespace {

struct FitArguments {
  std::vector<std::string> places;
  std::string method = "ceres", out, plot, seeds;
  std::map<std::string, std::string> options;  // of all learners, by flag
  std::uint64_t seed = 1;
  Output output;
};

std::vector<std::string> methods() {
  std::vector<std::string> all;
  for (const Learner& learner : learners()) all.push_back(learner.method);
  for (const Learner& learner : learners())
    if (learner.method != std::string(learner.name)) all.push_back(learner.name);
  return all;
}

const Learner& chosen_learner(const std::string& method) {
  return *std::find_if(learners().begin(), learners().end(),
                       [&](const Learner& l) { return method == l.method || method == l.name; });
}

// Options of other learners than the chosen one are refused.
void refuse_others(const CLI::App& verb, const Learner& chosen) {
  for (const Learner& learner : learners())
    for (const LearnerOption& option : learner.options)
      if (&learner != &chosen && verb.count(option.flag) > 0)
        throw CLI::ValidationError(option.flag, std::string("needs --method ") + learner.method);
}

void add_options(CLI::App& verb, const Learner& learner,
                 std::map<std::string, std::string>& values) {
  for (const LearnerOption& option : learner.options) {
    std::string& value = values[option.flag] = option.value;
    auto* added = verb.add_option(option.flag, value, option.help)->capture_default_str();
    if (option.most == LearnerOption::kSeed)
      added->type_name("UINT")->check(seed_rule());
    else if (option.choices.empty())
      added->type_name("UINT")->check(whole_number(option.least, option.most));
    else
      added->check(one_of(option.choices));
  }
}

Learned fitted(const Learner& learner, const DemonstrationSet& set, const FitArguments& a,
               std::uint64_t seed) {
  const EndsAfter heard_late("step");
  Progress progress("fitting", 1);
  try {
    return learner.learn(set, {seed, a.options},
                         [&](std::size_t done, std::size_t all, const std::string& note) {
                           progress(done, note, all);
                           return !interrupted();
                         });
  } catch (const BadInput& error) {
    if (interrupted()) throw Stopped();
    throw BadInput(fmt::format(
        "{}: {}", a.places.size() == 1 ? a.places[0] : fmt::format("{} places", a.places.size()),
        error.what()));
  }
}

void draw(const std::string& file, const DemonstrationSet& set, const Learned& result) {
  if (!result.curves.empty())
    write_svg(file, training_plot(result.curves));
  else if (const auto* law = std::get_if<LawFile>(&result.controller))
    write_svg(file, law_plot(set, *law));
  fmt::print(stderr, "wrote {}\n", printable(file));
}

// The line before the fit: which scenes the episodes are of.
std::string scenes_told(const DemonstrationSet& set) {
  const auto of = [](const Json& document) {
    return scene_text(document, changes_from_shipped(document));
  };
  if (set.undrawn_documents.size() == 1)
    return "scene " + of(set.undrawn_documents.front()) + ", of all episodes\n";
  return fmt::format("episodes of {} different scenes: {}\n", set.undrawn_documents.size(),
                     fmt::join(set.scenes, ", "));
}

// A number of a fit.
struct FitNumber {
  std::string name, unit;
  double value, low = NAN, high = NAN;  // 95 % interval, where there is one
};

// Residuals, and the gains of a law or a search.
std::vector<FitNumber> fit_numbers(const ControllerFile& controller) {
  std::vector<FitNumber> all;
  std::visit(
      [&](const auto& c) {
        all = {{"residual", "m/s", c.residual}, {"held_out_residual", "m/s", c.held_out_residual}};
      },
      controller);
  const auto* law = std::get_if<LawFile>(&controller);
  for (std::size_t i = 0; law && i < law->gains.size(); ++i) {
    const auto& [value, low, high] = law->gains[i];
    all.push_back({gain_of(law->kind, i).name, gain_of(law->kind, i).unit, value, low, high});
  }
  const auto* search = std::get_if<SearchFile>(&controller);
  for (std::size_t i = 0; search && i < kSearchGains.size(); ++i)
    all.push_back({kSearchGains[i].name, kSearchGains[i].unit, search->gains[i]});
  return all;
}

// A number of a fit under several seeds.
struct OverSeeds {
  std::string name, unit;
  std::vector<double> values;
};

// What each seed of --seeds makes of the same demonstrations.
std::vector<OverSeeds> over_seeds(const Learner& learner, const DemonstrationSet& set,
                                  const FitArguments& a) {
  std::vector<OverSeeds> all;
  if (a.seeds.empty()) return all;
  const auto add = [&](const FitNumber& number) {
    const auto place = std::find_if(all.begin(), all.end(),
                                    [&](const OverSeeds& o) { return o.name == number.name; });
    (place == all.end() ? all.emplace_back(OverSeeds{number.name, number.unit, {}}) : *place)
        .values.push_back(number.value);
  };
  for (const std::uint64_t seed : parse_seeds(a.seeds)) {
    if (interrupted()) break;
    const Learned result = fitted(learner, set, a, seed);
    if (trained_on(result.controller).partial) break;
    for (const FitNumber& number : fit_numbers(result.controller)) add(number);
  }
  return all;
}

std::string to_text(const std::vector<OverSeeds>& all) {
  std::string text;
  if (!all.empty())
    text = fmt::format("{:<32} {:>5} {:>12} {:>12} {:>12}\n", "over seeds of split and fit",
                       "seeds", "lowest", "median", "highest");
  for (const auto& [name, unit, values] : all)
    text += fmt::format("{:<32} {:>5} {:>12.5g} {:>12.5g} {:>12.5g}\n",
                        fmt::format("{} [{}]", name, unit), values.size(), quantile(values, 0),
                        quantile(values, 0.5), quantile(values, 1));
  return text;
}

// For --csv: every number of the fit, and how far it spreads over the seeds.
Json table(const ControllerFile& controller, const std::vector<OverSeeds>& spread) {
  Json rows = Json::array();
  for (const FitNumber& number : fit_numbers(controller)) {
    Json& row = rows.emplace_back(Json{{"name", number.name},
                                       {"unit", number.unit},
                                       {"value", number.value},
                                       {"low", number_or_null(number.low)},
                                       {"high", number_or_null(number.high)}});
    for (const auto& [name, unit, values] : spread)
      if (name == number.name)
        row["over_seeds"] = {{"seeds", values.size()},
                             {"lowest", quantile(values, 0)},
                             {"median", quantile(values, 0.5)},
                             {"highest", quantile(values, 1)}};
  }
  return rows;
}

// Where a fit goes that Ctrl-C stopped: never over one that is whole.
std::string partial_file(const std::string& file) {
  return std::filesystem::path(file).replace_extension(".partial.json").string();
}

int fit_verb(const FitArguments& a) {
  const Learner& learner = chosen_learner(a.method);
  if (!a.plot.empty() && !learner.drawn)
    throw BadInput("--plot: draws a law or the training of networks, not a search");
  expect_place_for(a.out);
  expect_place_for(a.plot);
  for (const std::string& file : learner.files(a.out)) expect_place_for(file);
  const DemonstrationSet set = load_demonstrations(episode_files(a.places), Loading());
  if (!a.seeds.empty()) parse_seeds(a.seeds);  // refused before anything is fitted
  const Learned result = fitted(learner, set, a, a.seed);
  const bool partial = trained_on(result.controller).partial;
  const std::string out = partial ? partial_file(a.out) : a.out;
  if (set.scenes.size() > 1)
    fmt::print(stderr, "note: the episodes are of {} different scenes: {}\n", set.scenes.size(),
               fmt::join(set.scenes, ", "));
  write_controller(out, result.controller);
  if (!a.plot.empty()) draw(a.plot, set, result);
  std::string notes;
  for (const std::string& warning : fit_warnings(set, result.controller))
    notes += "warning: " + warning + "\n";
  if (!a.output.text()) fmt::print(stderr, "{}", notes);
  Provenance provenance;
  provenance.seed("split and fit", a.seed);
  for (const Demonstration& d : set.demonstrations) provenance.read(d.file, d.sha1);
  const std::vector<OverSeeds> spread = over_seeds(learner, set, a);
  if (partial) provenance.partial("the best of the fit so far, in " + printable(out));
  if (!partial && interrupted() && !a.seeds.empty()) provenance.partial("the first of --seeds");
  if (a.output.text()) {
    fmt::print("{}{}{}{}{}wrote {}\n{}", scenes_told(set), provenance.head(), result.report,
               to_text(spread), notes, printable(out), provenance.foot());
  } else {
    Json json = parse_json(read_text(out), out);
    for (const auto& [name, unit, values] : spread) json["over_seeds"][name] = values;
    if (a.output.csv) json["table"] = table(result.controller, spread);
    print_result(a.output, json, "table", provenance);
  }
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_fit(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("fit", "Fit a controller to demonstrations");
  auto a = std::make_shared<FitArguments>();
  verb->add_option("episodes", a->places, "Folder with the episodes, or some of them by name")
      ->required()
      ->type_name("DIR|FILE...");
  verb->add_option("--method", a->method,
                   "How: a law, or the numbers of a search, with Ceres; or a policy with libtorch")
      ->capture_default_str()
      ->check(one_of(methods()));
  for (const Learner& learner : learners()) add_options(*verb, learner, a->options);
  add_plot(*verb, a->plot, "Draw the law over the data; with torch: the training curve");
  verb->add_option("--out", a->out, "Controller file")->required()->type_name("FILE.json");
  add_seed(*verb, a->seed, "Seed of the split into training and held-out episodes");
  add_seeds(*verb, a->seeds,
            "Fit with each of these seeds too, and print the spread of results and gains; the file "
            "is that of --seed");
  add_output(*verb, a->output);
  add_examples(*verb,
               {"fit episodes --out controller.json",
                "fit episodes --method torch --dagger 3 --plot training.svg --out policy.json"});
  verb->callback([a, verb, &run] {
    refuse_others(*verb, chosen_learner(a->method));
    run.verb = [a] { return fit_verb(*a); };
  });
}

}  // namespace ferrule
