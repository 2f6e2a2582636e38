// Demonstrations recorded, and a controller fitted to them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bindings.hpp"
#include "capture/recorder.hpp"
#include "insertion/simulated_operator.hpp"
#include "learn/fit_law.hpp"
#include "learn/fit_search.hpp"
#include "learn/fit_warnings.hpp"

namespace ferrule::python {
namespace {

// Episode by episode as `ferrule record` has them; returns their files.
std::vector<std::string> record(const SharedScene& scene, const std::filesystem::path& place,
                                int episodes, const std::string& told, std::uint64_t seed) {
  const std::string folder = place.string();
  if (episodes < 1) throw BadInput("episodes: must be at least 1");
  const OperatorSkill skill = OperatorSkill::parse(told);
  if (next_episode_number(folder) > 1)
    throw BadInput(folder + ": already holds episodes; choose another folder");
  std::vector<std::string> files;
  std::unique_ptr<Recorder> before;  // whose file is written while the next one is recorded
  Interrupts interrupts;
  const nb::gil_scoped_release release;
  int next = 1;
  for (int n = 0; n < episodes && !interrupts(); ++n, ++next) {
    EpisodeClaim claim(folder, next);
    const int number = next = claim.number();
    const TrialSetup trial = feasible_setup(*scene, seed, static_cast<std::uint64_t>(number));
    const auto hand = simulated_operator(trial, skill);
    EpisodeInfo info = episode_info(*trial.scene, *hand, seed, trial.trial);
    info.operator_ = SimulatedOperator{skill}.name();
    auto recorder = std::make_unique<Recorder>(std::move(claim), info);
    int ticks = 0;
    const InsertionEnd end = record_insertion(trial, *hand, *recorder,
                                              [&] { return ++ticks % 1000 != 0 || !interrupts(); });
    recorder->end(end.outcome);
    if (before) files.push_back(before->written());
    before = std::move(recorder);
  }
  if (before) files.push_back(before->written());
  interrupts.rethrow();  // the running episode was ended and kept
  return files;
}

// `law` of the method "ceres".
std::map<std::string, std::string> options(const Learner& learner, const std::string& law) {
  if (learner.options.empty()) return {};
  const LearnerOption& option = learner.options.front();
  if (std::find(option.choices.begin(), option.choices.end(), law) == option.choices.end())
    throw BadInput(
        fmt::format("law: there is no {}; there are {}", law, fmt::join(option.choices, ", ")));
  return {{option.flag, law}};
}

// `method`: "search", or a law with Ceres.
std::unique_ptr<LoadedController> fit(const std::vector<std::filesystem::path>& given,
                                      const std::string& method, const std::string& law,
                                      std::uint64_t seed) {
  const std::vector<std::string> places(given.begin(), given.end());
  const Learner learner = method == "search" ? search_learner() : law_learner();
  const LearnerSettings settings{seed, options(learner, law)};
  Interrupts interrupts;
  const nb::gil_scoped_release release;
  const DemonstrationSet set =
      load_demonstrations(episode_files(places), [&](std::size_t, std::size_t) {
        if (interrupts()) interrupts.rethrow();
      });
  try {
    Learned learned = learner.learn(
        set, settings, [&](std::size_t, std::size_t, const std::string&) { return !interrupts(); });
    interrupts.rethrow();
    auto controller =
        std::make_unique<LoadedController>(std::move(learned.controller), "the fitted controller");
    controller->report = std::move(learned.report);
    controller->warnings = fit_warnings(set, *controller->read);
    return controller;
  } catch (const BadInput& error) {
    interrupts.rethrow();
    throw BadInput(fmt::format(
        "{}: {}", places.size() == 1 ? places[0] : fmt::format("{} places", places.size()),
        error.what()));
  }
}

}  // namespace

void add_learning(nb::module_& module) {
  module.def("_record", &record, nb::arg("scene"), nb::arg("folder"), nb::arg("episodes"),
             nb::arg("skill"), nb::arg("seed"));
  module.def("_fit", &fit, nb::arg("episodes"), nb::arg("method"), nb::arg("law"), nb::arg("seed"));
}

}  // namespace ferrule::python
