#include "capture/haptic_loop.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

#include "haptic/trouble.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr double T = 2e-4;  // [s]

// A hand that pushes on at half the scene's speed for so many periods, with something that happens
// to it at one of them; and what it rendered.
class PushingHand : public Device {
 public:
  enum class Event { none, not_a_number, jump, silence, loss, trouble, standstill, stall };
  int periods = 1 << 30;
  std::atomic<int> reads = 0;
  std::vector<double> forces;     // |F| of each render [N]
  std::atomic<bool> free = true;  // of force

  explicit PushingHand(const Scene& scene, Event event = Event::none, int at = 0)
      : scaling_(scene_scaling(scene)), event_(event), at_(at) {
    start_ = scaling_.motion_to_hand(draw_start(scene, 1, 1).command);
    per_read_ = 0.5 * scaling_.motion * scene.limits.speed * T;
  }
  HandSample read(double) override {
    const int n = reads++;
    HandSample sample;
    sample.pose = start_;
    sample.pose[0] -= n * per_read_;
    sample.finished = n >= periods;
    if (n < at_) return sample;
    if (event_ == Event::trouble) throw DeviceTrouble("the device burns");
    if (event_ == Event::not_a_number) sample.pose[2] = NAN;
    if (event_ == Event::jump) sample.pose[1] += 0.01;
    if (event_ == Event::silence) sample.age = (n - at_ + 1) * T;
    if (event_ == Event::standstill && n == at_)
      std::this_thread::sleep_for(std::chrono::duration<double>(1.5 * kStandstill));
    if (event_ == Event::stall && n == at_)
      std::this_thread::sleep_for(std::chrono::duration<double>(1.5 * kStall));
    if (event_ == Event::loss) sample.lost = sample.finished = true;
    return sample;
  }
  void render(const HandWrench& wrench) override {
    forces.push_back(wrench.head<3>().norm());
    free = forces.back() == 0;
  }

 private:
  Scaling scaling_;
  Event event_;
  int at_;
  HandPose start_;
  double per_read_;
};

struct Kept {
  std::vector<RowVector> rows;
  void operator()(const RowVector& row, const RawCounts&) { rows.push_back(row); }
};

Request go_on() {
  return Request::go_on;
}

bool never() noexcept {
  return false;
}

std::atomic<bool> g_stopped = false;
bool stopped() noexcept {
  return g_stopped;
}

DeviceProfile pen() {
  DeviceProfile device = load_device_profile("pen");
  device.period = T;
  return device;
}

TimedEpisode run(const Scene& scene, Device& device,
                 const std::function<void(const RowVector&, const RawCounts&)>& record,
                 const std::function<Request()>& request = go_on,
                 ForceFeedback* feedback = nullptr) {
  return run_in_time(testing::felt_exactly(scene), device, testing::recording_settings(T, feedback),
                     record, request, never);
}

ForceFeedback feedback_of(const Scene& scene) {
  return {pen(), {}, scene_scaling(scene).motion_to_hand(draw_start(scene, 1, 1).command), 0};
}

TimedEpisode felt(const Scene& scene, PushingHand& hand, Kept& kept) {
  ForceFeedback feedback = feedback_of(scene);
  return run(scene, hand, std::ref(kept), go_on, &feedback);
}

// The thread, the clock and the ring change nothing in what is recorded.
TEST(HapticLoopInSeconds, RowsAreThoseOfTheLoopWithoutTime) {
  const Scene scene = testing::quick();
  const State start = draw_start(scene, 1, 1);
  const auto hand = simulated_operator(testing::setup(scene, 1), 1);
  const auto [end, alone] = testing::record_rows(scene, start, *hand);
  Kept kept;
  const auto again = simulated_operator(testing::setup(scene, 1), 1);
  const TimedEpisode timed =
      run_in_time(testing::setup(scene, start), *again, testing::recording_settings(),
                  std::ref(kept), go_on, never);
  EXPECT_EQ(timed.end.outcome, end.outcome);
  ASSERT_EQ(kept.rows.size(), alone.size());
  for (std::size_t n = 0; n < alone.size(); ++n) ASSERT_EQ(kept.rows[n], alone[n]) << n;
  EXPECT_EQ(timed.timing.periods.periods, alone.size() + 1);  // one read more than rows
}

// No force within two periods, the rows until then, and a reason.
TEST(HapticLoopInSeconds, WhatCannotBeTrustedEndsTheEpisodeWithoutForceAndKeepsItsRows) {
  using Event = PushingHand::Event;
  const Scene scene = testing::quick();
  constexpr int kAt = 400;
  for (const auto& [event, why] : {std::pair{Event::not_a_number, "not a finite number"},
                                   {Event::jump, "jumped"},
                                   {Event::silence, "too old"},
                                   {Event::loss, "lost"},
                                   {Event::standstill, "stood still"}}) {
    PushingHand hand(scene, event, kAt);
    Kept kept;
    const TimedEpisode episode = felt(scene, hand, kept);
    EXPECT_EQ(episode.end.outcome, Outcome::interrupted);
    EXPECT_NE(episode.end.why.find(why), std::string::npos) << episode.end.why;
    EXPECT_EQ(episode.end.lost, event == Event::loss);
    EXPECT_GE(kept.rows.size(), static_cast<std::size_t>(kAt)) << why;
    EXPECT_LE(hand.reads, kAt + 3) << why;
    EXPECT_EQ(hand.forces.back(), 0) << why;
    for (const RowVector& row : kept.rows) {
      ASSERT_TRUE(row.allFinite());
      ASSERT_LT(row.segment<kPose>(kCommand.begin).norm(), 2) << why;  // no hand is faster
    }
  }
}

TEST(HapticLoopInSeconds, WhatEndsAnEpisodeAfterTheGoalLeavesItInserted) {
  using Event = PushingHand::Event;
  const Scene scene =
      testing::paper({"start.distance_um=2", "success.depth_um=1", "limits.speed_um_s=20",
                      "start.lateral_sd_um=0", "start.lateral_mean_um=[0,0]"});
  constexpr int kAt = 2000;  // 4 um on, of 3
  for (const auto& [event, why] : {std::pair{Event::jump, "jumped"},
                                   {Event::silence, "too old"},
                                   {Event::loss, "lost"},
                                   {Event::standstill, "stood still"}}) {
    PushingHand hand(scene, event, kAt);
    Kept kept;
    const TimedEpisode episode = felt(scene, hand, kept);
    EXPECT_EQ(episode.end.outcome, Outcome::inserted) << why;
    EXPECT_NE(episode.end.why.find(why), std::string::npos) << episode.end.why;
    EXPECT_EQ(episode.end.lost, event == Event::loss);
  }
}

// The effects of a device have ended by then.
TEST(HapticLoop, AfterAStallTheForceRampsUpAgain) {
  const Scene scene = testing::quick();
  constexpr int kAt = 1000;
  PushingHand hand(scene, PushingHand::Event::stall, kAt);
  hand.periods = 2 * kAt;
  Kept kept;
  ForceFeedback feedback = feedback_of(scene);
  const ForceSensor noisy({.noise = 1e-8}, 1, 1);  // there is something to feel
  const TimedEpisode episode =
      run_in_time(testing::setup(scene, draw_start(scene, 1, 1), noisy), hand,
                  testing::recording_settings(T, &feedback), std::ref(kept), go_on, never);
  EXPECT_EQ(episode.end.outcome, Outcome::stopped_short) << episode.end.why;
  ASSERT_GT(hand.forces.size(), static_cast<std::size_t>(kAt + 500));
  const auto at = hand.forces.begin() + kAt;
  EXPECT_GT(*at, 0);
  EXPECT_EQ(*(at + 1), 0);
  EXPECT_LT(*std::max_element(at + 1, at + 20), *std::max_element(at - 20, at));
  EXPECT_GT(*(at + 500), 0);
}

// Without force there is no guard, and a pose that is not finite is no row.
TEST(HapticLoop, ADeviceWithoutForceThatIsNotFiniteKeepsItsRows) {
  const Scene scene = testing::quick();
  PushingHand hand(scene, PushingHand::Event::not_a_number, 100);
  Kept kept;
  const TimedEpisode episode = run(scene, hand, std::ref(kept));
  EXPECT_EQ(episode.end.outcome, Outcome::invalid_output);
  EXPECT_NE(episode.end.why.find("not a finite number"), std::string::npos);
  ASSERT_EQ(kept.rows.size(), 99u);
  for (const RowVector& row : kept.rows) ASSERT_TRUE(row.allFinite());
}

TEST(HapticLoop, TroubleOfTheDeviceComesThrough) {
  const Scene scene = testing::quick();
  PushingHand hand(scene, PushingHand::Event::trouble, 100);
  Kept kept;
  EXPECT_THROW(run(scene, hand, std::ref(kept)), DeviceTrouble);
  EXPECT_EQ(kept.rows.size(), 99u);  // a row is whole with the read after it
  EXPECT_EQ(hand.forces.back(), 0);
}

// The disk holds up the first row until the loop has gone on by 1000 periods.
TEST(HapticLoop, ASlowDiskDelaysNothing) {
  const Scene scene = testing::quick();
  PushingHand hand(scene);
  hand.periods = 1500;
  Kept kept;
  const TimedEpisode episode = run(scene, hand, [&](const RowVector& row, const RawCounts& counts) {
    while (kept.rows.empty() && hand.reads < 1000) std::this_thread::yield();
    kept(row, counts);
  });
  EXPECT_EQ(episode.end.outcome, Outcome::stopped_short);
  ASSERT_EQ(kept.rows.size(), 1500u);
  for (std::size_t n = 0; n < kept.rows.size(); ++n)
    ASSERT_EQ(kept.rows[n][kTime.begin], static_cast<double>(n) * T);
}

TEST(HapticLoop, ADiskThatStandsEndsTheEpisode) {
  const Scene scene = testing::paper({"start.distance_um=100"});
  PushingHand hand(scene);
  std::size_t rows = 0;
  const TimedEpisode episode = run_in_time(
      testing::felt_exactly(scene), hand, testing::recording_settings(1e-5),
      [&](const RowVector&, const RawCounts&) {
        const int most = static_cast<int>(kRing);
        while (rows == 0 && hand.reads < most) std::this_thread::yield();
        ++rows;
        if (rows == 1) std::this_thread::sleep_for(std::chrono::milliseconds(200));
      },
      go_on, never);
  EXPECT_EQ(episode.end.outcome, Outcome::interrupted);
  EXPECT_NE(episode.end.why.find("written"), std::string::npos);
  EXPECT_GE(rows, kRing);
  EXPECT_EQ(hand.forces.back(), 0);
}

TEST(HapticLoop, ADiskThatFailsEndsTheLoop) {
  const Scene scene = testing::quick();
  PushingHand hand(scene);
  EXPECT_THROW(
      run(scene, hand,
          [&](const RowVector&, const RawCounts&) { throw FileTrouble("the disk is full"); }),
      FileTrouble);
  EXPECT_EQ(hand.forces.back(), 0);
}

// The disk gives nothing back until the force is gone.
TEST(HapticLoop, StoppedItEndsWithinTwoPeriodsWhileTheDiskStands) {
  using Clock = std::chrono::steady_clock;
  const Scene scene = testing::quick();
  const ForceSensor noisy({.noise = 1e-8}, 1, 1);  // there is something to feel
  PushingHand hand(scene);
  Kept kept;
  int reads = 0;
  g_stopped = false;
  const TimedEpisode episode = run_in_time(
      testing::setup(scene, draw_start(scene, 1, 1), noisy), hand, testing::recording_settings(),
      [&](const RowVector& row, const RawCounts& counts) {
        if (kept.rows.empty()) {
          while (hand.reads < 50) std::this_thread::yield();
          EXPECT_FALSE(hand.free);
          g_stopped = true;
          reads = hand.reads;
          const auto end = Clock::now() + std::chrono::seconds(5);
          while (!hand.free && Clock::now() < end) std::this_thread::yield();
          EXPECT_TRUE(hand.free);
        }
        kept(row, counts);
      },
      go_on, stopped);
  EXPECT_LE(hand.reads, reads + 2);
  EXPECT_EQ(episode.end.outcome, Outcome::interrupted);
  EXPECT_EQ(static_cast<int>(kept.rows.size()), hand.reads - 1);
}

TEST(HapticLoop, TheCallingThreadEndsIt) {
  const Scene scene = testing::quick();
  for (const auto& [request, outcome] : {std::pair{Request::finish, Outcome::stopped_short},
                                         {Request::stop, Outcome::interrupted}}) {
    PushingHand hand(scene);
    Kept kept;
    const TimedEpisode episode = run(scene, hand, std::ref(kept), [&, asked = request] {
      return kept.rows.size() > 100 ? asked : Request::go_on;
    });
    EXPECT_EQ(episode.end.outcome, outcome);
    EXPECT_GT(kept.rows.size(), 100u);
  }
}

}  // namespace
}  // namespace ferrule
