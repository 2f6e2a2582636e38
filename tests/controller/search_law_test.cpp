#include "controller/search_law.hpp"

#include <gtest/gtest.h>

#include "controller/controller_file.hpp"
#include "controller/statistics.hpp"
#include "controller/stepped_trial.hpp"
#include "controller/supervisor.hpp"
#include "controller/trial.hpp"
#include "sim/base/data_folder.hpp"
#include "tests/refusal.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

std::string shipped() {
  return data_folder() + "/controllers/search.json";
}

struct Condition {
  const char* name;
  std::vector<std::string> settings;
};
void PrintTo(const Condition& condition, std::ostream* out) {
  *out << condition.name;
}

const std::vector<std::string> kSharp = {"ferrule.lead_in=null", "fibre.cleave_deg=0"};

std::vector<std::string> sharp_with(std::initializer_list<std::string> more) {
  std::vector<std::string> settings = kSharp;
  settings.insert(settings.end(), more);
  return settings;
}

class InsertsByTouch : public ::testing::TestWithParam<Condition> {};

// Below the force limit, with the one shipped file, in conditions that it is not told.
TEST_P(InsertsByTouch, InEveryTrial) {
  const Scene scene = load_scene("bench", GetParam().settings);
  const MakeController make = load_controller(shipped());
  for (std::uint64_t trial = 0; trial < 8; ++trial) {
    const auto law = make(trial);
    const TrialResult result = run_trial(scene, *law, 11, trial);
    EXPECT_EQ(result.outcome, Outcome::inserted) << trial;
    EXPECT_LT(result.summary.peak_force, 0.75 * scene.limits.force) << trial;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Conditions, InsertsByTouch,
    ::testing::Values(
        Condition{"AsItIs", {}}, Condition{"SharpBore", kSharp},
        Condition{"SharpBoreNearby", sharp_with({"start.lateral_sd_um=2"})},
        Condition{"CleavedEnd", sharp_with({"fibre.cleave_deg=0.5"})},
        Condition{"RoundedEdge", {"ferrule.lead_in=null", "fibre.edge_um=2"}},
        Condition{"OnTheFace", {"fibre.cleave_deg=0", "start.lateral_mean_um=[110,0]"}},
        Condition{"HandThatMovesFurther", sharp_with({"hand.gain=1.3"})},
        Condition{"LateHand", sharp_with({"hand.delay_ms=25"})},
        Condition{"LateHandAndACone", {"hand.delay_ms=10"}},
        Condition{"LateHandThatMovesLessAndACone", {"hand.delay_ms=40", "hand.gain=0.6"}},
        Condition{"LateHandThatMovesFurtherAndACone", {"hand.delay_ms=50", "hand.gain=1.4"}},
        Condition{"SluggishHand", sharp_with({"hand.smoothing_ms=20"})},
        Condition{"NarrowBore", sharp_with({"ferrule.bore_diameter_um=125.3"})},
        Condition{"WideBore", sharp_with({"ferrule.bore_diameter_um=126.5"})},
        Condition{"EntranceFurtherIn", sharp_with({"sensor.entrance_error_um=-4"})},
        Condition{"EntranceFurtherOut", sharp_with({"sensor.entrance_error_um=4"})},
        Condition{"NoisySensor", sharp_with({"sensor.noise_uN=2.5", "sensor.bias_uN=2.5"})},
        Condition{"NoisySensorAndSoftGripper",
                  sharp_with({"sensor.noise_uN=2.5", "sensor.bias_uN=2.5",
                              "holder.gripper_stiffness_N_m=20"})},
        Condition{"SoftGripper", sharp_with({"holder.gripper_stiffness_N_m=20"})}),
    [](const auto& info) { return info.param.name; });

// Nothing else in the program inserts there: not without a search.
TEST(SearchLaw, IsNeededAtASharpBore) {
  const Scene scene = load_scene("bench", kSharp);
  ConstantVelocity straight(scene.limits.speed * 250);
  int inserted = 0;
  for (std::uint64_t trial = 0; trial < 20; ++trial)
    inserted += run_trial(scene, straight, 11, trial).outcome == Outcome::inserted;
  EXPECT_LE(inserted, 2);
}

void expect_hardly_slower_under_the_supervisor(const Scene& scene, double times) {
  const MakeController alone = load_controller(shipped());
  const MakeController watched = supervised(alone, supervisor_limits(scene));
  int inserted_alone = 0, inserted = 0;
  std::vector<double> slower;
  for (std::uint64_t trial = 1; trial <= 20; ++trial) {
    const TrialResult by_itself = run_trial(scene, *alone(trial), 11, trial);
    const TrialResult with = run_trial(scene, *watched(trial), 11, trial);
    inserted_alone += by_itself.outcome == Outcome::inserted;
    inserted += with.outcome == Outcome::inserted;
    slower.push_back(with.summary.time / by_itself.summary.time);
    EXPECT_LT(with.summary.peak_force, scene.limits.force);
  }
  EXPECT_GE(inserted, std::max(inserted_alone - 2, 16));
  EXPECT_LT(quantile(slower, 0.5), times);
}

// Which lets it tilt in free air, where nothing is strained.
TEST(SearchLaw, IsHardlySlowerUnderTheSupervisor) {
  expect_hardly_slower_under_the_supervisor(load_scene("bench", sharp_with({})), 1.15);
}

// A noisy sensor makes the supervisor brake in free air; the hand is not late for that.
TEST(SearchLaw, IsHardlySlowerUnderASupervisorThatTheNoiseDisturbs) {
  expect_hardly_slower_under_the_supervisor(load_scene("ladder/b3"), 1.4);
}

// Nor is a touch with a gripper that gives way a jam, and a late hand goes where it is sent.
TEST(SearchLawInSeconds, IsHardlySlowerUnderASupervisorWithASoftGripperAndALateHand) {
  expect_hardly_slower_under_the_supervisor(load_scene("ladder/f"), 1.3);
}

TEST(SearchLawInSeconds, InABoreThatHoldsATiltedFibreItStraightens) {
  const std::vector<std::string> settings = {"ferrule.bore_diameter_um=125.3",
                                             "start.tilt_sd_mrad=6", "start.lateral_sd_um=3"};
  const Scene scene = load_scene("bench", settings);
  const MakeController search = load_controller(shipped());
  const MakeController tuned = load_controller(data_folder() + "/controllers/tuned_by_hand.json");
  int by_search = 0, by_tuned = 0;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    by_search += run_trial(scene, *search(trial), 12, trial).outcome == Outcome::inserted;
    by_tuned += run_trial(scene, *tuned(trial), 12, trial).outcome == Outcome::inserted;
  }
  EXPECT_GT(by_search, by_tuned + 5);
}

// There the cone is no higher than the entrance may be, as the face of a bore without one.
TEST(SearchLaw, NearTheAxisOfAConeItDoesNotTakeTheConeForAFace) {
  const Scene scene = load_scene("ladder/b1", {"start.lateral_sd_um=2"});
  const MakeController search = load_controller(shipped());
  int inserted = 0;
  for (std::uint64_t trial = 0; trial < 20; ++trial)
    inserted += run_trial(scene, *search(trial), 14, trial).outcome == Outcome::inserted;
  EXPECT_GE(inserted, 16);
}

// A tilt moves the fibre's side along the wall, which holds it by more than half of the force limit.
TEST(SearchLaw, InABoreWhoseFrictionIsHighItStraightensWithoutPulling) {
  const Scene scene = load_scene(
      "bench", {"ferrule.bore_diameter_um=125.4", "start.tilt_sd_mrad=4",
                "laws.friction.burgers_nm=1.03", "laws.adhesion.work_of_adhesion_J_m2=0.04"});
  const MakeController search = load_controller(shipped());
  int inserted = 0, pulled = 0;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    const TrialResult result = run_trial(scene, *search(trial), 13, trial);
    inserted += result.outcome == Outcome::inserted;
    pulled += result.summary.peak_force >= scene.limits.force;
  }
  EXPECT_GE(inserted, 16);
  EXPECT_LE(pulled, 1);
}

// In the bore, where it feels `force` [N].
double pressing_on(double force, double limit) {
  SearchLaw law(std::get<SearchFile>(read_controller(shipped())).gains);
  const auto felt = [&](double f, double time) {
    return observe(f * HandWrench::UnitX(), HandPose::Zero(), HandPose::Zero(), 1, time, limit);
  };
  law.command(felt(0, 0));
  EXPECT_STREQ(law.phase_name(), "insert");
  return -law.command(felt(force, 1e-3))[0];
}

TEST(SearchLaw, InsertsWithNoMoreThanNineTenthsOfTheForceLimit) {
  const double unlimited = pressing_on(4, std::numeric_limits<double>::infinity());
  EXPECT_GT(unlimited, 0);
  EXPECT_EQ(pressing_on(4, 8.46), unlimited);  // of bench
  EXPECT_GT(pressing_on(4, 4.5), 0);
  EXPECT_LT(pressing_on(4, 4.5), unlimited);
  EXPECT_EQ(pressing_on(4, 4.4), 0);
}

TEST(SearchLaw, SteppedFromOutsideTheTrialIsTheSame) {
  const auto scene = std::make_shared<Scene>(load_scene("bench", kSharp));
  const MakeController make = load_controller(shipped());
  for (std::uint64_t trial = 0; trial < 3; ++trial) {
    const auto inside = make(trial), outside = make(trial);
    const TrialResult run = run_trial(*scene, *inside, 5, trial);
    SteppedTrial stepped(scene, 5, trial);
    while (!stepped.ended()) stepped.step(outside->command(stepped.observation()));
    EXPECT_EQ(stepped.ended()->summary.time, run.summary.time);
    EXPECT_EQ(stepped.ended()->summary.peak_force, run.summary.peak_force);
  }
}

TEST(SearchFile, IsReadBackExactlyAndBrokenOnesAreRefusedWithTheirKey) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "search.json";
  const auto read = std::get<SearchFile>(read_controller(shipped()));
  write_controller(file, ControllerFile(read));
  const auto back = std::get<SearchFile>(read_controller(file));
  EXPECT_EQ(back.gains, read.gains);
  EXPECT_EQ(back.sources, read.sources);
  EXPECT_EQ(back.trained_on.scaling, read.trained_on.scaling);
  const Json good = parse_json(read_text(file), file);
  const auto says = [&](const char* pointer, const Json& value, const char* reason) {
    const std::string said = testing::refusal(file, good, pointer, value, read_controller);
    EXPECT_NE(said.find(reason), std::string::npos) << pointer << ": " << said;
  };
  says("/gains/tilt/value", 0, "gains.tilt.value = 0: must be positive");
  says("/gains/tilt/unit", "deg", "gains.tilt.unit");
  says("/gains/bore_radius/value", 0.0156, "must be larger than fibre_radius");
  says("/gains/mouth_radius/value", 0.01, "at most mouth_radius");
  says("/gains/surprise", 1, "unknown key");
  says("/metrics", 1, "unknown key");
}

}  // namespace
}  // namespace ferrule
