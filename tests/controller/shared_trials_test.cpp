#include "controller/shared_trials.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <thread>

#include "controller/campaign.hpp"
#include "controller/kept_trial.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"
#include "tests/refusal.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

constexpr std::uint64_t kSeed = 7;
constexpr std::size_t kTrials = 23;

// Some fail, some do not fit.
const Scene& task() {
  static const Scene scene =
      testing::paper({"start.lateral_sd_um=6", "start.distance_um=20", "success.depth_um=10",
                      "limits.force_uN=3", "ferrule.bore_diameter_um=125.2..126"});
  return scene;
}

MakeController straight() {
  return controller_maker(ConstantVelocity(scene_scaling(task()).motion * task().limits.speed));
}

void expect_same(const std::vector<TrialResult>& a, const std::vector<TrialResult>& b) {
  ASSERT_EQ(a.size(), b.size());
  const auto same = [](double x, double y) {
    return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y) ||
           (std::isnan(x) && std::isnan(y));
  };
  for (std::size_t k = 0; k < a.size(); ++k) {
    const InsertionSummary &s = a[k].summary, &t = b[k].summary;
    EXPECT_EQ(a[k].outcome, b[k].outcome) << k;
    EXPECT_EQ(a[k].why, b[k].why) << k;
    EXPECT_TRUE(same(a[k].loss_dB, b[k].loss_dB)) << k;
    EXPECT_EQ(a[k].light.offset, b[k].light.offset) << k;
    EXPECT_EQ(a[k].light.slope, b[k].light.slope) << k;
    for (auto number :
         {&InsertionSummary::time, &InsertionSummary::reached, &InsertionSummary::touched,
          &InsertionSummary::outside, &InsertionSummary::peak_force, &InsertionSummary::peak_stress,
          &InsertionSummary::friction_work, &InsertionSummary::depth, &InsertionSummary::offset,
          &InsertionSummary::tilt})
      EXPECT_TRUE(same(s.*number, t.*number)) << k;
    EXPECT_EQ(s.tip, t.tip) << k;
    EXPECT_EQ(s.steps, t.steps) << k;
    EXPECT_EQ(s.unfinished, t.unfinished) << k;
    ASSERT_EQ(a[k].supervision.has_value(), b[k].supervision.has_value()) << k;
    if (!a[k].supervision) continue;
    EXPECT_EQ(a[k].supervision->interventions, b[k].supervision->interventions) << k;
    EXPECT_EQ(a[k].supervision->gave_up, b[k].supervision->gave_up) << k;
  }
}

struct SharedTrialsOfACampaign : ::testing::Test {
  testing::TemporaryFolder folder;
  MakeController make = straight();

  std::vector<TrialResult> alone(const IsEnough& enough = {}) {
    return run_campaign(task(), make, kSeed, kTrials, 0, {}, {}, enough);
  }
  std::vector<TrialResult> run(SharedTrials& shared, const IsEnough& enough = {},
                               const std::function<bool()>& stop = {}) {
    return run_campaign(task(), make, kSeed, kTrials, 0, {}, stop, enough, &shared);
  }
  std::vector<TrialResult> shard(std::size_t index, std::size_t count,
                                 const IsEnough& enough = {}) {
    SharedTrials shared(folder.path(), "job", Shard{index, count}, false);
    std::vector<TrialResult> results = run(shared, enough);
    shared.finish();
    return results;
  }
  std::vector<TrialResult> merged(const IsEnough& enough = {}) {
    SharedTrials shared(folder.path(), "job", std::nullopt, false);
    return run(shared, enough);
  }
};

TEST_F(SharedTrialsOfACampaign, AreThoseOfOneProcess) {
  for (const std::size_t count : {1, 3, 40}) {  // of 40 most have no trial
    for (std::size_t i = count; i >= 1; --i) EXPECT_TRUE(shard(i, count).empty());
    expect_same(merged(), alone());
    std::filesystem::remove_all(folder.path());
    std::filesystem::create_directory(folder.path());
  }
}

using SharedTrialsOfACampaignInSeconds = SharedTrialsOfACampaign;
TEST_F(SharedTrialsOfACampaignInSeconds, KeepWhatASupervisorDid) {
  make = supervised(make, supervisor_limits(task()));
  for (const std::size_t i : {1, 2}) shard(i, 2);
  const auto results = merged();
  expect_same(results, alone());
  EXPECT_TRUE(std::any_of(results.begin(), results.end(), [](const TrialResult& r) {
    return r.supervision && r.supervision->interventions != Supervision().interventions;
  }));
}

// Those that are shown one by one, and the first ones that are returned.
TEST_F(SharedTrialsOfACampaign, ComeInTheirOrder) {
  for (const std::size_t i : {1, 2, 3}) shard(i, 3);
  const std::vector<TrialResult> expected = alone();
  SharedTrials shared(folder.path(), "job", std::nullopt, false);
  for (SharedTrials* const from : {static_cast<SharedTrials*>(nullptr), &shared}) {
    std::vector<TrialResult> shown;
    const auto kept =
        run_campaigns({{&task(), make, {}, [&](const TrialResult& r) { shown.push_back(r); }, 5}},
                      kSeed, kTrials, 0, {}, {}, from);
    expect_same(shown, expected);
    expect_same(kept.front(), {expected.begin(), expected.begin() + 5});
  }
}

// Three insertions are enough: those of the shards in the order of the trials.
TEST_F(SharedTrialsOfACampaign, EndWhereItIsEnough) {
  const auto after_three = [] {
    return [left = 3](const TrialResult& r) mutable {
      return r.outcome == Outcome::inserted && --left == 0;
    };
  };
  const auto expected = alone(after_three());
  EXPECT_LT(expected.size(), kTrials);
  for (const std::size_t i : {1, 2}) shard(i, 2, after_three());
  expect_same(merged(after_three()), expected);
}

// Stopped after a few trials, and once killed while it wrote.
TEST_F(SharedTrialsOfACampaign, GoOnWhereTheyWereStopped) {
  std::atomic<int> asked = 0;
  {
    SharedTrials shared(folder.path(), "job", Shard{1, 1}, false);
    std::atomic<std::size_t> done = 0;
    run_campaign(
        task(), make, kSeed, kTrials, 1, [&](std::size_t n) { done = n; },
        [&] { return done >= 5; }, {}, &shared);
  }
  const std::string file = folder / "shard_0001_of_0001.trials";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  {
    SharedTrials shared(folder.path(), "job", Shard{1, 1}, false);
    std::atomic<std::size_t> done = 0;
    run_campaign(
        task(), make, kSeed, kTrials, 1, [&](std::size_t n) { done = n; },
        [&] { return done >= 5; }, {}, &shared);
  }
  const MakeController counted = [&, inner = make](std::uint64_t trial) {
    ++asked;
    return inner(trial);
  };
  make = counted;
  shard(1, 1);
  EXPECT_EQ(asked, kTrials - 5);
  expect_same(merged(), alone());
}

TEST_F(SharedTrialsOfACampaign, AreRefusedWhereSomeAreMissing) {
  shard(1, 3);
  shard(3, 3);
  EXPECT_EQ(testing::refusal([&] { merged(); }),
            "trouble: " + folder.path() +
                ": of campaign 1, 8 trials are missing, 1 the first: run shard 2/3 again");
  SharedTrials shared(folder.path(), "job", std::nullopt, false);
  const SharedTrials::Progress::NotDone left = shared.progress().not_done();
  EXPECT_EQ(to_text(left.first, left.count), "shard 2/3");
}

// The same trials in shards of two counts: they are counted once, unless they went differently.
TEST_F(SharedTrialsOfACampaign, MayBeThereTwiceIfTheyAreTheSame) {
  shard(1, 1);
  for (const std::size_t i : {1, 2}) shard(i, 2);
  {
    SharedTrials shared(folder.path(), "job", std::nullopt, false);
    expect_same(run(shared), alone());
    EXPECT_EQ(shared.progress().twice, kTrials);
  }
  {  // begun once more, in shards of which two are not run: it is whole all the same
    SharedTrials third(folder.path(), "job", Shard{1, 3}, false);
    run(third);
    third.finish();
    const SharedTrials::Progress progress =
        SharedTrials(folder.path(), "job", std::nullopt, false).progress();
    EXPECT_EQ(progress.count(), 3);
    EXPECT_EQ(progress.not_done().count, 0);
  }
  make = controller_maker(ConstantVelocity(1e-3));
  for (const std::size_t i : {1, 2, 3}) shard(i, 3);
  EXPECT_NE(testing::refusal([&] { merged(); }).find("is there twice and went differently"),
            std::string::npos);
}

TEST_F(SharedTrialsOfACampaign, OfOtherJobsAreLeftOut) {
  for (const std::size_t i : {1, 2}) {
    SharedTrials other(folder.path(), "other job", Shard{i, 2}, false);
    run(other);
    other.finish();
  }
  SharedTrials shared(folder.path(), "job", std::nullopt, false);
  EXPECT_TRUE(shared.progress().counts.empty());
  EXPECT_EQ(shared.progress().trials, 0);
  EXPECT_GT(shared.progress().others, 0);
}

TEST_F(SharedTrialsOfACampaign, OfAnotherSceneAreRefused) {
  shard(1, 1);
  SharedTrials shared(folder.path(), "job", std::nullopt, false);
  const std::string why = testing::refusal(
      [&] { run_campaign(task(), make, kSeed + 1, kTrials, 0, {}, {}, {}, &shared); });
  EXPECT_NE(why.find("has trials of another scene as campaign 1"), std::string::npos) << why;
}

// What comes next depends on the results: both have all of them.
TEST_F(SharedTrialsOfACampaign, WaitForEachOther) {
  std::vector<std::vector<TrialResult>> found(2);
  const auto run_waiting = [&](std::size_t i) {
    SharedTrials shared(folder.path(), "job", Shard{i + 1, 2}, true);
    found[i] = run(shared);
  };
  std::thread other(run_waiting, 0);
  run_waiting(1);
  other.join();
  for (const auto& results : found) expect_same(results, alone());
}

// As a stranger may make them: right checksums, the right job, and something else in it.
TEST_F(SharedTrialsOfACampaign, RefusesWhatNoShardHasWritten) {
  const Json trial = kept_trial(run_campaign(task(), make, kSeed, 1, 1, {}).front());
  std::string what;
  shard(1, 1);
  BlockReader(folder / "shard_0001_of_0001.trials")
      .read(
          [&](const Json& block, const BlockReader::Place&) { what = block.value("what", what); });
  const Json good = {{"job", "job"}, {"shard", {1, 1}}, {"campaign", 0},
                     {"what", what}, {"of", kTrials},   {"trials", {{0, trial}}}};
  const auto changed = [&](const char* place, const Json& value) {
    Json block = good;
    block[Json::json_pointer(place)] = value;
    return block;
  };
  const Json blocks[] = {
      Json(3),
      Json::array({1, 2}),
      changed("/job", 5),
      changed("/shard", "1/1"),
      changed("/shard", {1}),
      changed("/shard", {0, 1}),
      changed("/shard", {2, 1}),
      changed("/shard", {-1, 1}),
      changed("/campaign", "first"),
      changed("/campaign", -1),
      changed("/what", Json::object()),
      changed("/of", "many"),
      changed("/trials", 7),
      changed("/trials", {7}),
      changed("/trials/0", Json::array()),
      changed("/trials/0/0", -3),
      changed("/trials/0/0", 1.5),
      changed("/trials/0/1", "inserted"),
      changed("/trials/0/1/0", 1000),
      changed("/trials/0/1/0", -1),
      changed("/trials/0/1/1", Json::array()),
      changed("/trials/0/1/7", 3),
      changed("/trials/0/1/8", {Json::array(), 99}),
  };
  const std::string file = folder / "shard_0001_of_0001.trials";
  for (const Json& block : blocks) {
    std::filesystem::remove(file);
    BlockWriter(file).append(block);
    const std::string said = testing::refusal([&] {
      SharedTrials shared(folder.path(), "job", std::nullopt, false);
      run(shared);
    });
    EXPECT_EQ(said, "trouble: " + file + ": has no trials of this program in the block at byte 12")
        << block;
  }
}

}  // namespace
}  // namespace ferrule
