#include "insertion/loop.hpp"

#include <cstring>

#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"
#include "tests/allocations.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// A hand at a velocity that follows from what it felt last, with something that happens at a read.
class KnownHand : public Device {
 public:
  std::function<HandTwist(const HandWrench&)> velocity = [](const HandWrench&) {
    return HandTwist(HandTwist::Zero());
  };
  std::function<void(int, HandSample&)> happens = [](int, HandSample&) {};
  std::vector<HandWrench> rendered;

  KnownHand(const Scene& scene, const State& start)
      : pose_(scene_scaling(scene).motion_to_hand(start.command)) {}
  HandSample read(double t) override {
    pose_ += velocity_ * (t - time_);
    time_ = t;
    HandSample sample{pose_};
    happens(reads_++, sample);
    return sample;
  }
  void render(const HandWrench& wrench) override {
    rendered.push_back(wrench);
    velocity_ = velocity(wrench);
  }

 private:
  HandPose pose_;
  HandTwist velocity_ = HandTwist::Zero();
  double time_ = 0;
  int reads_ = 0;
};

HandTwist straight_in(double speed) {
  HandTwist v = HandTwist::Zero();
  v[0] = -speed;
  return v;
}

// Whatever happens to a hand that pushes slowly, to either end.
struct Ended {
  InsertionEnd end;
  int ticks = 0;
};
Ended run(const Scene& scene, const std::function<void(int, HandSample&)>& happens,
          bool past_success, double speed = 1e-3, int stop_after = 1 << 30) {
  const State start = draw_start(scene, 1, 1);
  KnownHand hand(scene, start);
  hand.velocity = [&](const HandWrench&) { return straight_in(speed); };
  hand.happens = happens;
  LoopSettings settings = testing::recording_settings();
  settings.past_success = past_success;
  Ended ended;
  ended.end = run_insertion(testing::setup(scene, start), hand, settings,
                            [&](const Tick&) { return ++ended.ticks < stop_after; });
  return ended;
}

TEST(Loop, ATickPairsAForceWithTheVelocityThatAnswersIt) {
  const Scene scene = testing::paper();
  const Scaling scaling = scene_scaling(scene);
  const State start = draw_start(scene, 1, 1);
  KnownHand hand(scene, start);
  hand.velocity = [](const HandWrench& wrench) {
    HandTwist v;
    v << -2e-3, 1e-3 * wrench.tail<4>();
    return v;
  };
  hand.happens = [](int n, HandSample& sample) { sample.finished = n == 5000; };
  const auto rows = testing::record_rows(scene, start, hand).rows;
  ASSERT_EQ(rows.size(), 5000u);
  const HandWrench rest = scaling.wrench_to_hand(rows[0].segment<5>(kHolder.begin).transpose());
  for (std::size_t n = 0; n < rows.size(); ++n) {
    EXPECT_CLOSE(rows[n][kTime.begin], static_cast<double>(n) * 1e-3, 1e-14);
    const HandWrench wrench =
        scaling.wrench_to_hand(rows[n].segment<5>(kHolder.begin).transpose()) - rest;
    EXPECT_LT(std::abs(rows[n][kCommand.begin + 1] - 1e-3 * wrench[1]), 1e-10 * 2e-3);
    if (n == 0) continue;
    EXPECT_EQ(rows[n].segment<5>(kHandVelocity.begin), rows[n - 1].segment<5>(kCommand.begin));
    const Eigen::Matrix<double, 1, 5> moved =
        rows[n].segment<5>(kHandPose.begin) - rows[n - 1].segment<5>(kHandPose.begin);
    EXPECT_LT((moved - 1e-3 * rows[n - 1].segment<5>(kCommand.begin)).norm(), 1e-15);
  }
}

// Through a sensor with every error: the weight is in the reading, and no hand feels it.
TEST(Loop, WhatAHandFeelsIsRelativeToRest) {
  const Scene scene = load_scene("bench");
  const State start = draw_start(scene, 1, 1);
  KnownHand hand(scene, start);
  std::vector<HandWrench> wrench, relative;
  run_insertion(testing::setup(scene, 1), hand, testing::recording_settings(),
                [&](const Tick& tick) {
                  wrench.push_back(tick.wrench);
                  relative.push_back(tick.relative);
                  return wrench.size() < 300;
                });
  EXPECT_LT(wrench[0][1], 0);
  EXPECT_EQ(relative[0], HandWrench::Zero());
  EXPECT_NE(relative[1], HandWrench::Zero());
  ASSERT_EQ(hand.rendered.size(), relative.size());
  for (std::size_t n = 0; n < wrench.size(); ++n) {
    EXPECT_EQ(relative[n], wrench[n] - wrench[0]);
    EXPECT_EQ(hand.rendered[n], relative[n]);
  }
}

// The recording goes on after the trial has its outcome, and is the same until then, bit for bit.
TEST(Loop, ARecordingAndATrialOfAControllerAreTheSame) {
  const Scene scene = load_scene("demo");
  const Scaling scaling = scene_scaling(scene);
  std::array<int, kOutcomes> outcomes{};
  for (std::uint64_t trial = 1; trial <= 8; ++trial) {
    ConstantVelocity controller(scaling.motion * scene.limits.speed);
    const TrialResult alone = run_trial(scene, controller, 1, trial);
    const State start = draw_start(scene, 1, trial);
    ControllerHand hand = recorded_hand(testing::setup(scene, start), controller);
    InsertionWatch watch(scene, start);
    std::optional<Outcome> first;
    int after = 0;
    const InsertionEnd end = run_insertion(testing::setup(scene, trial), hand,
                                           testing::recording_settings(), [&](const Tick& tick) {
                                             if (first) ++after;
                                             if (!first) first = watch.after(tick.result);
                                             return true;
                                           });
    ASSERT_TRUE(first);
    EXPECT_EQ(*first, alone.outcome);
    EXPECT_EQ(std::memcmp(&watch.summary(), &alone.summary, sizeof alone.summary), 0) << trial;
    EXPECT_EQ(after > 0, alone.outcome == Outcome::inserted);
    if (after == 0) {
      EXPECT_EQ(end.outcome, alone.outcome);
    }
    ++outcomes[static_cast<std::size_t>(alone.outcome)];
  }
  EXPECT_GT(outcomes[static_cast<std::size_t>(Outcome::inserted)], 0);
  EXPECT_LT(outcomes[static_cast<std::size_t>(Outcome::inserted)], 8);
}

// Its own way is no measure of how deep the fibre is.
TEST(Loop, ARecordedHandThatTheHolderFollowsLessGoesOnUntilTheFibreIsDeep) {
  const Scene scene = load_scene("demo", {"hand.gain=0.7", "hand.delay_ms=10"});
  const Scaling scaling = scene_scaling(scene);
  int inserted = 0;
  for (std::uint64_t trial = 1; trial <= 8; ++trial) {
    ConstantVelocity controller(scaling.motion * scene.limits.speed);
    const TrialResult alone = run_trial(scene, controller, 1, trial);
    const State start = draw_start(scene, 1, trial);
    ControllerHand hand = recorded_hand(testing::setup(scene, start), controller);
    const InsertionEnd end =
        run_insertion(testing::setup(scene, trial), hand, testing::recording_settings());
    EXPECT_EQ(end.outcome, alone.outcome) << trial;
    inserted += alone.outcome == Outcome::inserted;
  }
  EXPECT_GT(inserted, 0);
}

TEST(Loop, PastSuccessTheHandSaysWhenItIsFinished) {
  const Scene scene = testing::quick();
  const Ended trial = run(
      scene, [](int, HandSample&) {}, false, 8e-3);
  EXPECT_EQ(trial.end.outcome, Outcome::inserted);
  const int more = trial.ticks + 100;
  const Ended recording = run(
      scene, [more](int n, HandSample& sample) { sample.finished = n >= more; }, true, 8e-3);
  EXPECT_EQ(recording.end.outcome, Outcome::inserted);
  EXPECT_EQ(recording.ticks, more);
  EXPECT_GT(recording.end.summary.depth, trial.end.summary.depth);
}

// What happens to a fibre that is in already does not undo that it went in.
TEST(Loop, AFailurePastSuccessEndsItAsInserted) {
  const Scene scene = testing::quick();
  const Ended ended = run(
      scene,
      [&](int, HandSample& sample) {
        const double past = hand_depth(sample.pose) / scene_scaling(scene).motion;
        if (past > scene.success.depth + 1e-6) sample.pose[1] += 1;  // against the bore's wall
      },
      true, 8e-3);
  EXPECT_EQ(ended.end.outcome, Outcome::inserted);
  ASSERT_TRUE(ended.end.afterwards.has_value());
  EXPECT_NE(*ended.end.afterwards, Outcome::inserted);
  EXPECT_NE(ended.end.why.find("past the success depth"), std::string::npos);
  EXPECT_GT(ended.end.summary.reached, 0);
  EXPECT_LT(ended.end.summary.reached, ended.end.summary.time);
  EXPECT_EQ(ended.end.summary.task_time(), ended.end.summary.reached);
}

// Nor does anything else that happens then.
TEST(Loop, WhateverComesAfterSuccessItIsInserted) {
  const Scene scene = testing::quick();
  const auto in = [&scene](auto what) {
    return [&scene, what](int, HandSample& sample) {
      if (hand_depth(sample.pose) / scene_scaling(scene).motion > scene.success.depth + 1e-6)
        what(sample);
    };
  };
  const Ended lost = run(scene, in([](HandSample& s) { s.lost = s.finished = true; }), true, 8e-3);
  EXPECT_TRUE(lost.end.lost);
  EXPECT_NE(lost.end.why.find("the device was lost"), std::string::npos);
  const Ended broken = run(scene, in([](HandSample& s) { s.pose[3] = NAN; }), true, 8e-3);
  EXPECT_EQ(broken.end.afterwards, Outcome::invalid_output);
  const Ended stopped = run(scene, in([](HandSample& s) { s.finished = true; }), true, 8e-3);
  EXPECT_FALSE(stopped.end.afterwards.has_value());
  const Ended alone = run(
      scene, [](int, HandSample&) {}, false, 8e-3);
  const Ended interrupted = run(
      scene, [](int, HandSample&) {}, true, 8e-3, alone.ticks + 50);
  EXPECT_EQ(interrupted.end.afterwards, Outcome::interrupted);
  for (const Ended& each : {lost, broken, stopped, interrupted})
    EXPECT_EQ(each.end.outcome, Outcome::inserted) << each.end.why;
}

TEST(Loop, ATrialWhoseTimeRunsOutSaysSo) {
  for (const char* limit : {"limits.time_s=5", "limits.time_s=10"}) {
    const Scene scene = testing::quick({limit});
    const Ended trial = run(
        scene, [](int, HandSample&) {}, false, 0);
    EXPECT_EQ(trial.end.outcome, Outcome::timeout);
    EXPECT_GE(trial.end.summary.time, scene.limits.time);
  }
}

TEST(Loop, AHandEndsItByWhatItIsOrSays) {
  const Scene scene = testing::quick();
  constexpr int kAt = 300;
  const auto at = [](auto what) {
    return [what](int n, HandSample& sample) {
      if (n >= kAt) what(sample);
    };
  };
  for (const bool past_success : {false, true}) {
    const Ended broken = run(scene, at([](HandSample& s) { s.pose[3] = NAN; }), past_success);
    EXPECT_EQ(broken.end.outcome, Outcome::invalid_output);
    EXPECT_NE(broken.end.why.find("not a finite number"), std::string::npos);
    EXPECT_EQ(broken.ticks, kAt - 1);

    const Ended lost =
        run(scene, at([](HandSample& s) { s.lost = s.finished = true; }), past_success);
    EXPECT_EQ(lost.end.outcome, Outcome::interrupted);
    EXPECT_TRUE(lost.end.lost);
    EXPECT_EQ(lost.ticks, kAt);

    const Ended stopped = run(scene, at([](HandSample& s) { s.finished = true; }), past_success);
    EXPECT_EQ(stopped.end.outcome, Outcome::stopped_short);
    EXPECT_EQ(stopped.ticks, kAt);

    const auto gives_up = [](HandSample& s) {
      s.finished = true;
      s.gave_up = "no way on";
    };
    const Ended gave_up = run(scene, at(gives_up), past_success);
    EXPECT_EQ(gave_up.end.outcome, Outcome::gave_up);
    EXPECT_EQ(gave_up.end.why, "no way on");
    EXPECT_EQ(gave_up.ticks, kAt);
    EXPECT_CLOSE(gave_up.end.summary.time, (kAt - 1) * 1e-3, 1e-12);
  }
}

TEST(Loop, ThereIsOneTickAtLeastAndWhoListensMayEndIt) {
  const Scene scene = testing::quick();
  const Ended at_once = run(
      scene, [](int, HandSample& s) { s.finished = true; }, true);
  EXPECT_EQ(at_once.end.outcome, Outcome::stopped_short);
  EXPECT_EQ(at_once.ticks, 1);
  const Ended interrupted = run(
      scene, [](int, HandSample&) {}, true, 1e-3, 77);
  EXPECT_EQ(interrupted.end.outcome, Outcome::interrupted);
  EXPECT_EQ(interrupted.ticks, 77);
  const Ended nowhere = run(
      scene, [](int, HandSample& s) { s.pose[0] = INFINITY; }, true);
  EXPECT_EQ(nowhere.end.outcome, Outcome::invalid_output);
  EXPECT_EQ(nowhere.ticks, 0);
}

TEST(Loop, AllocatesNothingBetweenTicks) {
  const Scene scene = load_scene("bench");
  const auto hand = simulated_operator(testing::setup(scene, 1), 0.8);
  std::size_t first = 0, last = 0, ticks = 0;
  run_insertion(testing::setup(scene, 1), *hand, testing::recording_settings(), [&](const Tick&) {
    last = testing::allocations();
    if (ticks++ == 0) first = last;
    return true;
  });
  EXPECT_GT(ticks, 1000u);
  EXPECT_EQ(last, first);
}

}  // namespace
}  // namespace ferrule
