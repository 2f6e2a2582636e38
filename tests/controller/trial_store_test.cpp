#include "controller/trial_store.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <thread>

#include "controller/campaign.hpp"
#include "controller/supervisor.hpp"
#include "controller/trial_fields.hpp"
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

struct StoredTrials : ::testing::Test {
  testing::TemporaryFolder folder;
  MakeController make = straight();

  std::vector<TrialResult> alone(const IsEnough& enough = {}) {
    return run_campaign(task(), make, kSeed, kTrials, 0, {}, {}, enough);
  }
  std::vector<TrialResult> run(TrialStore& shared, const IsEnough& enough = {},
                               const std::function<bool()>& stop = {}) {
    return run_campaign(task(), make, kSeed, kTrials, 0, {}, stop, enough, &shared);
  }
  std::vector<TrialResult> shard(std::size_t index, std::size_t count,
                                 const IsEnough& enough = {}) {
    TrialStore shared(folder.path(), "job", Shard{index, count}, false);
    std::vector<TrialResult> results = run(shared, enough);
    shared.finish();
    return results;
  }
  JobProgress progress() {
    ShardFiles files(folder.path(), "job");
    files.read_all();
    return files.progress();
  }
  std::vector<TrialResult> merged(const IsEnough& enough = {}) {
    TrialStore shared(folder.path(), "job", std::nullopt, false);
    return run(shared, enough);
  }
};

TEST_F(StoredTrials, AreThoseOfOneProcess) {
  for (const std::size_t count : {1, 3, 40}) {  // of 40 most have no trial
    for (std::size_t i = count; i >= 1; --i) EXPECT_TRUE(shard(i, count).empty());
    expect_same(merged(), alone());
    std::filesystem::remove_all(folder.path());
    std::filesystem::create_directory(folder.path());
  }
}

using StoredTrialsInSeconds = StoredTrials;
TEST_F(StoredTrialsInSeconds, KeepWhatASupervisorDid) {
  make = supervised(make, supervisor_limits(task()));
  for (const std::size_t i : {1, 2}) shard(i, 2);
  const auto results = merged();
  expect_same(results, alone());
  EXPECT_TRUE(std::any_of(results.begin(), results.end(), [](const TrialResult& r) {
    return r.supervision && r.supervision->interventions != Supervision().interventions;
  }));
}

// Those that are shown one by one, and the first ones that are returned.
TEST_F(StoredTrials, ComeInTheirOrder) {
  for (const std::size_t i : {1, 2, 3}) shard(i, 3);
  const std::vector<TrialResult> expected = alone();
  TrialStore shared(folder.path(), "job", std::nullopt, false);
  for (TrialStore* const from : {static_cast<TrialStore*>(nullptr), &shared}) {
    std::vector<TrialResult> shown;
    const auto kept =
        run_campaigns({{&task(), make, {}, [&](const TrialResult& r) { shown.push_back(r); }, 5}},
                      kSeed, kTrials, 0, {}, {}, from);
    expect_same(shown, expected);
    expect_same(kept.front(), {expected.begin(), expected.begin() + 5});
  }
}

// Three insertions are enough: those of the shards in the order of the trials.
TEST_F(StoredTrials, EndWhereItIsEnough) {
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
TEST_F(StoredTrials, GoOnWhereTheyWereStopped) {
  std::atomic<int> asked = 0;
  {
    TrialStore shared(folder.path(), "job", Shard{1, 1}, false);
    std::atomic<std::size_t> done = 0;
    run_campaign(
        task(), make, kSeed, kTrials, 1, [&](std::size_t n) { done = n; },
        [&] { return done >= 5; }, {}, &shared);
  }
  const std::string file = folder / "shard_0001_of_0001.trials";
  std::filesystem::resize_file(file, std::filesystem::file_size(file) - 1);
  {
    TrialStore shared(folder.path(), "job", Shard{1, 1}, false);
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

TEST_F(StoredTrials, AreRefusedWhereSomeAreMissing) {
  shard(1, 3);
  shard(3, 3);
  EXPECT_EQ(testing::refusal([&] { merged(); }),
            "trouble: " + folder.path() +
                ": of campaign 1, 8 trials are missing, 1 the first: run shard 2/3 again");
  const JobProgress::NotDone left = progress().not_done();
  EXPECT_EQ(to_text(left.first, left.count), "shard 2/3");
}

// The same trials in shards of two counts: they are counted once, unless they went differently.
TEST_F(StoredTrials, MayBeThereTwiceIfTheyAreTheSame) {
  shard(1, 1);
  for (const std::size_t i : {1, 2}) shard(i, 2);
  {
    TrialStore shared(folder.path(), "job", std::nullopt, false);
    expect_same(run(shared), alone());
    EXPECT_EQ(shared.twice(), kTrials);
  }
  {  // begun once more, in shards of which two are not run: it is whole all the same
    TrialStore third(folder.path(), "job", Shard{1, 3}, false);
    run(third);
    third.finish();
    EXPECT_EQ(progress().count(), 3);
    EXPECT_EQ(progress().not_done().count, 0);
  }
  make = controller_maker(ConstantVelocity(1e-3));
  for (const std::size_t i : {1, 2, 3}) shard(i, 3);
  EXPECT_NE(testing::refusal([&] { merged(); }).find("is there twice and went differently"),
            std::string::npos);
}

TEST_F(StoredTrials, OfOtherJobsAreLeftOut) {
  for (const std::size_t i : {1, 2}) {
    TrialStore other(folder.path(), "other job", Shard{i, 2}, false);
    run(other);
    other.finish();
  }
  EXPECT_TRUE(progress().counts.empty());
  EXPECT_EQ(progress().trials, 0);
  EXPECT_GT(progress().others, 0);
}

TEST_F(StoredTrials, OfAnotherSceneAreRefused) {
  shard(1, 1);
  TrialStore shared(folder.path(), "job", std::nullopt, false);
  const std::string why = testing::refusal(
      [&] { run_campaign(task(), make, kSeed + 1, kTrials, 0, {}, {}, {}, &shared); });
  EXPECT_NE(why.find("has trials of another scene as campaign 1"), std::string::npos) << why;
}

// What comes next depends on the results: both have all of them.
TEST_F(StoredTrials, WaitForEachOther) {
  std::vector<std::vector<TrialResult>> found(2);
  const auto run_waiting = [&](std::size_t i) {
    TrialStore shared(folder.path(), "job", Shard{i + 1, 2}, true);
    found[i] = run(shared);
  };
  std::thread other(run_waiting, 0);
  run_waiting(1);
  other.join();
  for (const auto& results : found) expect_same(results, alone());
}

// As a stranger may make them: right checksums, the right job, and something else in it.
TEST_F(StoredTrials, RefuseWhatNoShardHasWritten) {
  Json good;
  shard(1, 1);
  const std::string file = folder / "shard_0001_of_0001.trials";
  BlockReader(file).read([&](const Json& block, const BlockReader::Place&) {
    if (!block.value("trial", Json::array()).empty()) good = block;
  });
  ASSERT_FALSE(good.is_null());
  const auto refused = [&](const Json& block) {
    std::filesystem::remove(file);
    BlockWriter(file).append(block);
    return testing::refusal([&] {
      TrialStore shared(folder.path(), "job", std::nullopt, false);
      run(shared);
    });
  };
  const auto changed = [&](const std::string& place, const Json& value) {
    Json block = good;
    block[Json::json_pointer(place)] = value;
    return block;
  };
  std::vector<Json> blocks = {Json(3),
                              Json::array({1, 2}),
                              changed("/version", "2"),
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
                              changed("/trial", 7),
                              changed("/trial/0", -3),
                              changed("/trial/0", 1.5),
                              changed("/trial/0", Json::array()),
                              changed("/columns", Json::array()),
                              changed("/columns/outcome/0", "flew away"),
                              changed("/columns/outcome/0", 0),
                              changed("/columns/interventions/0", {{"held", 1}}),
                              changed("/columns/why/0", 3)};
  for (const TrialField& field : kTrialFields) {
    const std::string column = std::string("/columns/") + field.name;
    blocks.push_back(changed(column, Json::array()));
    blocks.push_back(changed(column + "/0", "much"));
    blocks.push_back(good);
    blocks.back()["columns"].erase(field.name);
  }
  for (const Json& block : blocks)
    EXPECT_EQ(refused(block),
              "trouble: " + file + ": has no trials of this program in the block at byte 12")
        << block;
  for (const int version : {1, 3})
    EXPECT_EQ(refused(changed("/version", version)),
              "trouble: " + file + ": is of version " + std::to_string(version) +
                  " of these files, this program has 2: run its shard again, in another folder");
}

// Each field is a number of its own, and all numbers of a result are fields.
TEST(TrialFields, HoldEveryNumber) {
  TrialResult result{};
  double next = 1;
  for (const TrialField& field : kTrialFields) field.of(result) = next++;
  const double expected = (next - 1) * next / 2;
  double sum = 0;
  for (const TrialField& field : kTrialFields) sum += value(field, result);
  EXPECT_EQ(sum, expected);
  const InsertionSummary& s = result.summary;
  EXPECT_EQ(s.time + s.reached + s.touched + s.outside + s.peak_force + s.peak_stress +
                s.friction_work + s.depth + s.offset + s.tilt + s.tip.sum() + result.loss_dB +
                result.light.offset.sum() + result.light.slope.sum(),
            expected);
}

}  // namespace
}  // namespace ferrule
