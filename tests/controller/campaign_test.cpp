#include "controller/campaign.hpp"

#include <atomic>

#include "capture/episode.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/base/random.hpp"
#include "tests/compare.hpp"
#include "tests/controller/law.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

Scene quick(const std::string& more = "limits.force_uN=3") {
  return testing::paper({"start.lateral_sd_um=6", "start.distance_um=20", "success.depth_um=10",
                         "limits.force_uN=3", more});
}

TEST(Statistics, WilsonIntervalsAt15Digits) {
  EXPECT_CLOSE(wilson(8, 10).low, 0.490162471536642, 1e-13);
  EXPECT_CLOSE(wilson(8, 10).high, 0.943317848545625, 1e-13);
  EXPECT_CLOSE(wilson(499, 500).low, 0.988759293294853, 1e-13);
  EXPECT_CLOSE(wilson(1, 1000).high, 0.00564255859795794, 1e-13);
  EXPECT_EQ(wilson(0, 20).low, 0);
  EXPECT_CLOSE(wilson(0, 20).high, 0.161125158052819, 1e-13);
  EXPECT_EQ(wilson(20, 20).high, 1);
}

// With so many trials at that rate the interval begins above it, with one fewer it does not.
TEST(Statistics, TrialsToShowARateAreThoseOfTheInterval) {
  for (const double rate : {0.99, 0.999}) {
    const std::size_t all = 300 + trials_to_show(rate, 300, 300).value();
    EXPECT_GE(wilson(all, all).low, rate);
    EXPECT_LT(wilson(all - 1, all - 1).low, rate);
  }
  // Of 200 trials one failed: the rate is the same again in every other multiple of 200.
  const std::size_t more = trials_to_show(0.99, 199, 200).value();
  const std::size_t above = (200 + more + 199) / 200, below = (200 + more) / 200;
  EXPECT_GE(wilson(199 * above, 200 * above).low, 0.99);
  EXPECT_LT(wilson(199 * below, 200 * below).low, 0.99);
  EXPECT_LT(below, above);
  EXPECT_EQ(trials_to_show(0.99, 1000, 1000), std::size_t{0});
  EXPECT_FALSE(trials_to_show(0.99, 990, 1000));
  EXPECT_FALSE(trials_to_show(0.999, 199, 200));
  EXPECT_FALSE(trials_to_show(0.99, 0, 0));
}

TEST(Statistics, McNemarAt15Digits) {
  EXPECT_CLOSE(mcnemar_p(3, 10), 0.09228515625, 1e-12);
  EXPECT_CLOSE(mcnemar_p(0, 5), 0.0625, 1e-12);
  EXPECT_EQ(mcnemar_p(7, 7), 1);
  EXPECT_EQ(mcnemar_p(0, 0), 1);
  EXPECT_CLOSE(mcnemar_p(40, 12), 0.000127538783855741, 1e-11);
}

TEST(Statistics, QuantilesInterpolateBetweenOrderStatistics) {
  EXPECT_EQ(quantile({3, 1, 2}, 0.5), 2);
  EXPECT_EQ(quantile({1, 2, 3, 4}, 0.5), 2.5);
  EXPECT_CLOSE(quantile({1, 2, 3, 4}, 0.95), 3.85, 1e-14);
  EXPECT_TRUE(std::isnan(quantile({}, 0.5)));
}

// The ranks r of the sign test: the largest for which P(X <= r - 1) <= 0.025, X binomial (n, 1/2):
// P(X <= 0) = 0.016 of 6, P(X <= 1) = 0.0195 of 9 and 0.011 of 10, P(X <= 5) = 0.021 of 20,
// P(X <= 9) = 0.021 of 30.
TEST(Statistics, IntervalsOfTheMedianLieBetweenTheRanksOfTheSignTest) {
  for (const auto& [n, low, high] :
       {std::tuple(6, 1, 6), {9, 2, 8}, {10, 2, 9}, {20, 6, 15}, {30, 10, 21}}) {
    std::vector<double> values;
    for (int k = 0; k < n; ++k) values.push_back((7 * k) % n + 1.0);  // 1 to n, not in order
    EXPECT_EQ(median_interval(values).low, low) << n;
    EXPECT_EQ(median_interval(values).high, high) << n;
  }
  EXPECT_TRUE(std::isnan(median_interval({1, 2, 3, 4, 5}).low));
  EXPECT_TRUE(std::isnan(median_interval({}).high));
}

// At least 95 %, and not much more, of a distribution with a long tail.
TEST(Statistics, IntervalsOfTheMedianHoldItAsOftenAsTheySay) {
  int inside = 0;
  constexpr int kSamples = 4000;
  for (int s = 0; s < kSamples; ++s) {
    RandomStream random(1, static_cast<std::uint64_t>(s), Draw::start);
    std::vector<double> values(40);
    for (double& v : values) v = -std::log(random.uniform());
    const Interval i = median_interval(values);
    inside += i.low <= std::log(2.0) && std::log(2.0) <= i.high;
  }
  EXPECT_GT(inside, 0.95 * kSamples);
  EXPECT_LT(inside, 0.98 * kSamples);
}

TEST(Campaign, IsTheSameForAnyNumberOfThreads) {
  const Scene scene = quick();
  const auto one = run_campaign(scene, controller_maker(kLaw), 7, 24, 1, {});
  for (const int threads : {2, 3, 0}) {
    const auto many = run_campaign(scene, controller_maker(kLaw), 7, 24, threads, {});
    for (std::size_t k = 0; k < one.size(); ++k) {
      EXPECT_EQ(one[k].outcome, many[k].outcome);
      EXPECT_EQ(one[k].summary.peak_force, many[k].summary.peak_force);
      EXPECT_EQ(one[k].summary.offset, many[k].summary.offset);
      EXPECT_EQ(one[k].summary.time, many[k].summary.time);
    }
  }
}

// One of ten minutes too; what ran then is not among the results.
TEST(Campaign, IsStoppedWithinATrial) {
  Scene scene = testing::paper({"limits.time_s=3600"});
  class Waits : public Controller {
   public:
    explicit Waits(std::atomic<int>& asked) : asked_(asked) {}
    HandTwist command(const Observation&) noexcept override {
      ++asked_;
      return HandTwist::Zero();
    }

   private:
    std::atomic<int>& asked_;
  };
  std::atomic<int> asked = 0;
  const auto results = run_campaign(
      scene, [&](std::uint64_t) { return std::make_unique<Waits>(asked); }, 7, 100, 2, {},
      [&] { return asked > 1000; });
  EXPECT_TRUE(results.empty());
  EXPECT_LT(asked, 10'000);
}

// The shortest beginning of the whole campaign that is enough, on any number of threads.
TEST(Campaign, EndsWithTheFirstTrialAfterWhichEnoughIsKnown) {
  const Scene scene = quick();
  const auto run = [&](int threads, const std::function<bool(const TrialResult&)>& enough) {
    return run_campaign(scene, controller_maker(ConstantVelocity(2e-3)), 7, 40, threads, {}, {},
                        enough);
  };
  const auto whole = run(0, {});
  for (const int threads : {1, 2, 7}) {
    int failures = 0;
    const auto some = run(threads, [&](const TrialResult& r) {
      return (failures += r.outcome != Outcome::inserted) == 3;
    });
    ASSERT_LT(some.size(), whole.size());
    int left = 3;
    for (std::size_t k = 0; k < some.size(); ++k) {
      EXPECT_GT(left, 0);
      left -= whole[k].outcome != Outcome::inserted;
      EXPECT_EQ(some[k].outcome, whole[k].outcome);
      EXPECT_EQ(some[k].summary.peak_force, whole[k].summary.peak_force);
    }
    EXPECT_EQ(left, 0);
    EXPECT_EQ(run(threads, [](const TrialResult&) { return false; }).size(), whole.size());
  }
}

TEST(Campaign, SummaryCountsEveryTrialOnce) {
  const Scene scene = quick();
  const auto results = run_campaign(scene, controller_maker(ConstantVelocity(2e-3)), 7, 40, 0, {});
  const CampaignSummary s = summarise(results);
  std::size_t sum = 0;
  for (const std::size_t n : s.outcomes) sum += n;
  EXPECT_EQ(sum, 40u);
  EXPECT_EQ(s.successes, s.outcomes[static_cast<std::size_t>(Outcome::inserted)]);
  EXPECT_GT(s.successes, 0u);
  EXPECT_LT(s.successes, 40u);
}

TEST(Campaign, ComparisonPairsTheTrials) {
  std::vector<TrialResult> a(10), b(10);
  for (std::size_t k = 0; k < 10; ++k) {
    a[k].outcome = k < 8 ? Outcome::inserted : Outcome::jam;
    b[k].outcome = k % 2 ? Outcome::inserted : Outcome::force_limit;
    a[k].summary.time = 10 + static_cast<double>(k % 4);
    b[k].summary.time = a[k].summary.time + static_cast<double>(k % 4 == 1 ? 1 : 3);
    a[k].summary.peak_force = 1e-6 * static_cast<double>(k);
  }
  const Comparison c = compare(a, b);
  EXPECT_CLOSE(c.difference, 0.3, 1e-12);
  EXPECT_CLOSE(c.mcnemar_p, mcnemar_p(4, 1), 1e-14);
  EXPECT_CLOSE(c.time.median, -2, 1e-12);  // where both inserted: k = 1, 3, 5, 7
  EXPECT_TRUE(std::isnan(c.time.interval.low));
  EXPECT_CLOSE(c.peak_force.median, 4.5e-6, 1e-9);
  EXPECT_CLOSE(c.peak_force.interval.high, 8e-6, 1e-9);
  b.pop_back();
  EXPECT_THROW(compare(a, b), std::invalid_argument);
  EXPECT_CLOSE(compare_shared(a, b).value().difference, 4.0 / 9, 1e-12);
  EXPECT_FALSE(compare_shared(a, {}));
}

TEST(Campaign, ConnectorsThatLoseTooMuchFailAndAreNotMated) {
  Scene scene = quick();
  const auto run = [&] {
    return run_campaign(scene, controller_maker(ConstantVelocity(2e-3)), 7, 40, 0, {});
  };
  const auto all = run();
  std::vector<double> losses;
  for (const TrialResult& r : all)
    if (r.outcome == Outcome::inserted) {
      losses.push_back(r.loss_dB);
      EXPECT_EQ(r.loss_dB, joint_loss_dB(scene.joint, r.light));
      EXPECT_EQ(r.light.offset.norm(), r.summary.offset);
    }
  scene = quick("success.loss_dB=" + Json(quantile(losses, 0.5)).dump());
  const auto some = run();
  std::size_t lossy = 0;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const bool loses =
        all[k].outcome == Outcome::inserted && all[k].loss_dB > scene.success.loss_dB;
    EXPECT_EQ(some[k].outcome, loses ? Outcome::high_loss : all[k].outcome);
    if (loses) {
      EXPECT_EQ(some[k].loss_dB, all[k].loss_dB);
    }
    lossy += loses;
  }
  EXPECT_EQ(summarise(some).successes, losses.size() - lossy);
  EXPECT_GT(lossy, 0u);
  const Scene perfect =
      testing::paper({"joint.core_concentricity_sd_um=0", "joint.bore_concentricity_sd_um=0"});
  EXPECT_LT(mated(perfect, some, 7).untuned.p97_dB, mated(perfect, all, 7).untuned.p97_dB);
}

// What is recorded with a controller at the hand's place is what a trial of it does.
TEST(Trial, IsWhatARecordingOfTheControllerShows) {
  const testing::TemporaryFolder folder;
  const Scene scene = quick();
  for (std::uint64_t trial = 1; trial <= 4; ++trial) {
    Law law = kLaw;
    const TrialResult result = run_trial(scene, law, 1, trial);
    const Episode episode = read_episode(testing::record(scene, folder.path(), trial, &law));
    EXPECT_EQ(episode.info.outcome == Outcome::inserted, result.outcome == Outcome::inserted);
    const auto n = static_cast<Eigen::Index>(std::lround(result.summary.time * 1e3));
    ASSERT_LT(n, episode.rows.rows());
    EXPECT_EQ(result.summary.offset,
              Vector2d(episode.rows.row(n).segment<2>(state_column("tip_y")).transpose()).norm());
  }
}

TEST(Trial, AControllerThatIsNotFiniteEndsItsTrial) {
  class Broken : public Controller {
   public:
    HandTwist command(const Observation& observation) noexcept override {
      HandTwist v = HandTwist::Zero();
      v[0] = observation.time > 0.1 ? NAN : -1e-3;
      return v;
    }
  } broken;
  const Scene scene = quick();
  EXPECT_EQ(run_trial(scene, broken, 1, 1).outcome, Outcome::invalid_output);
}

TEST(LimitSpeed, CutsTheTranslationAndKeepsItsDirection) {
  HandTwist v;
  v << -3, 4, 0, 1, 2;
  const HandTwist cut = limit_speed(v, 2.5);
  EXPECT_CLOSE(cut.head<3>().norm(), 2.5, 1e-14);
  EXPECT_CLOSE(cut[1] / cut[0], -4.0 / 3, 1e-14);
  EXPECT_EQ(cut[3], 1);
  EXPECT_EQ(limit_speed(v, 6), v);
}

}  // namespace
}  // namespace ferrule
