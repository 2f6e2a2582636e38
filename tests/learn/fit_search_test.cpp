#include "learn/fit_search.hpp"

#include <gtest/gtest.h>

#include "controller/searching_operator.hpp"
#include "learn/record_again.hpp"
#include "sim/scene/draw.hpp"
#include "tests/episodes.hpp"

namespace ferrule {
namespace {

SearchFile shipped() {
  return std::get<SearchFile>(read_controller("search"));
}

double& gain(std::vector<double>& gains, std::string_view name) {
  std::size_t i = 0;
  while (kSearchGains.at(i).name != name) ++i;
  return gains[i];
}

// The law with these numbers, recorded as a person is.
DemonstrationSet searched_with(const std::vector<double>& gains, const Scene& scene,
                               std::uint64_t episodes) {
  DemonstrationSet set;
  for (std::uint64_t trial = 1; trial <= episodes; ++trial) {
    const State start = draw_start(scene, 1, trial);
    SearchLaw law(gains);
    ControllerHand hand = recorded_hand(testing::setup(scene, start), law);
    Episode episode;
    episode.info = testing::info_of(scene, 1, trial);
    std::vector<RowVector> rows;
    std::vector<PhaseBegin> phases;
    episode.info.outcome =
        run_insertion(testing::setup(scene, trial), hand, testing::recording_settings(),
                      [&](const Tick& tick) {
                        note_phase(phases, static_cast<Eigen::Index>(rows.size()),
                                   law.phase_name());
                        rows.push_back(make_row(tick));
                        return true;
                      })
            .outcome;
    episode.info.phases = phases_text(phases);
    episode.rows = testing::RecordedRows{{}, rows}.matrix();
    set.add(episode, "episode " + std::to_string(trial), "");
  }
  return set;
}

// As many episodes of an operator of `skill`.
DemonstrationSet searched_by(double skill, const Scene& scene, std::size_t episodes) {
  DemonstrationSet of;
  of.operators.assign(episodes, SimulatedOperator{skill, true}.name());
  of.undrawn_documents = {undrawn(scene.document())};
  return record_again(of, 3);
}

// Relative errors: of the force at which a touch begins, what grows in a period is a good part.
const std::vector<std::pair<const char*, double>> kToBeFound = {
    {"approach_speed", 0.01}, {"touch_speed", 0.02}, {"insert_speed", 0.01}, {"tilt_rate", 0.02},
    {"touch_force", 0.25},    {"push_force", 0.03},  {"hold_time", 0.05},    {"lift", 0.05},
    {"tilt", 0.03},           {"yield", 0.03},       {"near_entrance", 0.03}};

// In a bore that holds a fibre up, or the force with which it pushes would show nowhere.
TEST(FitSearch, FindsTheNumbersOfWhoSearches) {
  std::vector<double> gains = shipped().gains;
  double factor = 0.7;
  for (const auto& [name, error] : kToBeFound) gain(gains, name) *= factor += 0.05;
  const Scene tight = load_scene("ladder/d", {"ferrule.bore_diameter_um=125.3"});
  const SearchFit fit = fit_search(searched_with(gains, tight, 6), 1);
  EXPECT_EQ(fit.reaction_time, 0);
  std::vector<double> found = fit.controller.gains;
  for (const auto& [name, error] : kToBeFound)
    EXPECT_NEAR(gain(found, name), gain(gains, name), error * gain(gains, name)) << name;
  for (const char* name : {"turn_moment", "fibre_radius", "bore_radius", "mouth_radius"})
    EXPECT_EQ(gain(found, name), gain(gains, name)) << name;
  EXPECT_EQ(fit.controller.trained_on.episodes.size(), 5U);
  EXPECT_EQ(fit.controller.trained_on.held_out.size(), 1U);
}

// A person is late and slower by his skill, trembles and hesitates; none of it is learned but the
// speed. He turns as fast as his delay lets him, so that his tilt rate does not show.
TEST(FitSearchInSeconds, OfAnOperatorIsFasterThanHe) {
  constexpr double kSkill = 0.9;
  const Scene scene = load_scene("by_hand/sharp");
  const DemonstrationSet set = searched_by(kSkill, scene, 6);
  const SearchFit fit = fit_search(set, 1);
  const TraineeTraits traits = trainee_traits(kSkill);
  EXPECT_NEAR(fit.reaction_time, traits.delay, 0.011);
  std::vector<double> gains = shipped().gains, found = fit.controller.gains;
  gain(gains, "insert_speed") *= traits.peak_speed;
  for (const auto& [name, error] : {std::pair{"insert_speed", 0.02},
                                    {"touch_force", 0.25},
                                    {"hold_time", 0.2},
                                    {"lift", 0.1},
                                    {"tilt", 0.03},
                                    {"yield", 0.15}})
    EXPECT_NEAR(gain(found, name), gain(gains, name), error * gain(gains, name)) << name;
  EXPECT_LT(gain(found, "tilt_rate"), gain(gains, "tilt_rate"));

  double longest = 0, shortest = INFINITY;
  for (std::uint64_t trial = 0; trial < 10; ++trial) {
    const TrialResult result = run_trial(scene, *fit.controller.maker()(trial), 5, trial);
    EXPECT_EQ(result.outcome, Outcome::inserted) << trial;
    longest = std::max(longest, result.summary.time);
  }
  for (const Demonstration& d : set.demonstrations)
    shortest = std::min(shortest, d.period * static_cast<double>(d.rows()));
  EXPECT_LT(longest, shortest);
}

TEST(FitSearch, NeedsPhasesAndTheScalingOfTheSearch) {
  const Scene paper = load_scene("paper", {"start.distance_um=10", "success.depth_um=8"});
  EXPECT_THROW(fit_search(simulated_demonstrations(paper, 0.8, 1, 4), 1), BadInput);
  DemonstrationSet set = searched_with(shipped().gains, load_scene("ladder/c"), 3);
  EXPECT_THROW(fit_search(set, 1), BadInput);  // two to learn from
  set = searched_with(shipped().gains, load_scene("ladder/c"), 4);
  EXPECT_NO_THROW(fit_search(set, 1));
  set.scaling->force *= 2;
  EXPECT_THROW(fit_search(set, 1), BadInput);
}

// The last insertion ends with the last row, wherever between two rows it begins: further than that
// the sanitizers see.
TEST(FitSearch, ReadsNoFurtherThanTheLastRow) {
  DemonstrationSet set = searched_with(shipped().gains, load_scene("ladder/c"), 4);
  for (Demonstration& d : set.demonstrations)
    d.phases.back().begin = (static_cast<double>(d.rows()) - 200.5) * d.period;
  EXPECT_TRUE(std::isfinite(fit_search(set, 1).controller.residual));
}

// A number that is seen too seldom stays.
TEST(FitSearch, KeepsWhatTheDemonstrationsDoNotTell) {
  DemonstrationSet set = searched_with(shipped().gains, load_scene("ladder/c"), 4);
  for (Demonstration& d : set.demonstrations) d.phases.resize(1);  // the approach
  const SearchFit fit = fit_search(set, 1);
  for (std::size_t i = 0; i < kSearchGains.size(); ++i) {
    if (std::string_view(kSearchGains.at(i).name) == "approach_speed") continue;
    EXPECT_EQ(fit.controller.gains[i], shipped().gains[i]) << kSearchGains.at(i).name;
    EXPECT_FALSE(std::isfinite(fit.gains[i].low)) << kSearchGains.at(i).name;
    EXPECT_TRUE(fit.controller.sources[i].ends_with(shipped().sources[i]));
  }
}

}  // namespace
}  // namespace ferrule
