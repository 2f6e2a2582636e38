#include "learn/record_again.hpp"

#include "controller/searching_operator.hpp"
#include "insertion/loop.hpp"
#include "insertion/simulated_operator.hpp"

namespace ferrule {
namespace {

Episode recorded_episode(const Scene& toleranced, const SimulatedOperator& who, std::uint64_t seed,
                         std::uint64_t number) {
  const TrialSetup setup = feasible_setup(toleranced, seed, number);
  const Scene& scene = *setup.scene;
  Episode episode;
  EpisodeInfo& info = episode.info;
  info.scene = scene.document().dump();
  info.operator_ = who.name();
  info.seed = seed;
  info.trial = setup.trial;
  std::unique_ptr<Controller> search;
  std::unique_ptr<Device> hand;
  if (who.searches) {
    search = searching_operator(scene, who.skill, seed)(setup.trial);
    hand = std::make_unique<ControllerHand>(recorded_hand(setup, *search));
  } else {
    hand = simulated_operator(setup, who.skill, info.period);
  }
  std::vector<RowVector> rows;
  std::vector<PhaseBegin> phases;
  info.outcome = run_insertion(setup, *hand, {.period = info.period, .past_success = true},
                               [&](const Tick& tick) {
                                 if (search)
                                   note_phase(phases, static_cast<Eigen::Index>(rows.size()),
                                              search->phase_name());
                                 rows.push_back(make_row(tick));
                                 return true;
                               })
                     .outcome;
  info.phases = phases_text(phases);
  episode.rows.resize(static_cast<Eigen::Index>(rows.size()), Eigen::NoChange);
  for (std::size_t n = 0; n < rows.size(); ++n)
    episode.rows.row(static_cast<Eigen::Index>(n)) = rows[n];
  return episode;
}

void add_recorded(DemonstrationSet& set, const Scene& scene, const SimulatedOperator& who,
                  std::uint64_t seed, std::uint64_t trial) {
  set.add(recorded_episode(scene, who, seed, trial),
          "episode " + std::to_string(trial) + " under seed " + std::to_string(seed), "");
}

}  // namespace

void expect_recordable_again(const DemonstrationSet& set) {
  if (set.undrawn_documents.size() != 1)
    throw BadInput("the episodes are of several scenes: which to record in again is not clear");
  for (const std::string& name : set.operators)
    if (!SimulatedOperator::named(name))
      throw BadInput("\"" + name + "\" is no simulated operator: nobody can record again");
}

DemonstrationSet record_again(const DemonstrationSet& set, std::uint64_t seed,
                              const std::function<void()>& go_on) {
  expect_recordable_again(set);
  const Scene scene = parse_scene(set.undrawn_documents.front(), "the scene of the episodes");
  DemonstrationSet again;
  std::uint64_t trial = 0;
  for (const std::string& name : set.operators) {
    if (go_on) go_on();
    ++trial;
    add_recorded(again, scene, SimulatedOperator::named(name).value(), seed, trial);
  }
  return again;
}

DemonstrationSet simulated_demonstrations(const Scene& scene, const OperatorSkill& skill,
                                          std::uint64_t seed, std::size_t count) {
  DemonstrationSet set;
  for (std::uint64_t trial = 1; trial <= count; ++trial)
    add_recorded(set, scene, {skill}, seed, trial);
  return set;
}

}  // namespace ferrule
