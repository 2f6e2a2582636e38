#include "haptic/hid/force_stick.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "haptic/hid/fake_firmware.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr double kReach = 0.05, kFull = 8;

HandPose start_pose() {
  HandPose pose;
  pose << 0.03, -0.001, 0.002, 1e-3, -2e-3;
  return pose;
}

HandSample read_at(ForceStick& stick, FakeFirmware& firmware, double t) {
  firmware.advance(t);
  return stick.read(t);
}

TEST(ForceStick, ItsPositionIsTheHandsFromWhereItStood) {
  for (const FakeModel model : {FakeModel::pid_18, FakeModel::pid_22}) {
    FakeFirmware firmware(model);
    firmware.deflect({1000, -2000, 3000, 0, 0, 0});
    firmware.advance(0);
    ForceStick stick(firmware, kReach, kFull, start_pose());
    ASSERT_EQ(stick.mapping()->kind, Mapping::Kind::position);
    EXPECT_EQ(read_at(stick, firmware, 0.001).pose, start_pose());
    firmware.deflect({1000 - 16384, -2000 + 8192, 3000 + 4096, 0, 0, 0});
    const HandSample sample = read_at(stick, firmware, 0.002);
    EXPECT_EQ(sample.counts[0], 1000 - 16384);
    const HandPose moved = sample.pose - start_pose();
    const double count = kReach / 32767;
    EXPECT_NEAR(moved[0], -16384 * count, 1e-15);
    EXPECT_NEAR(moved[1], -8192 * count, 1e-15);
    EXPECT_NEAR(moved[2], 4096 * count, 1e-15);
    EXPECT_EQ(moved[3], 0);
    EXPECT_EQ(moved[4], 0);
  }
}

// Power into the hand is power out of the fibre: force times motion agree in sign and size on the
// device's axes and in the hand's world.
TEST(ForceStick, ForcesPushAgainstTheMotionTheyBelongTo) {
  FakeFirmware firmware(FakeModel::pid_22);
  ForceStick stick(firmware, kReach, kFull, start_pose());
  HandWrench wrench;
  wrench << 2, -4, 100, 100, 100;  // out of the bore, downwards; z and moments have no motor
  for (int n = 0; n < 20; ++n) {
    read_at(stick, firmware, n * 1e-3);
    stick.render(wrench);
  }
  const auto force = firmware.force();
  EXPECT_CLOSE(force[0], 0.25, 1e-4);  // of 10,000 steps
  EXPECT_CLOSE(force[1], 0.5, 1e-4);
  for (Eigen::Index axis = 0; axis < 2; ++axis)
    EXPECT_CLOSE(force[static_cast<std::size_t>(axis)] * kFull * stick.mapping()->gain(axis, axis),
                 wrench[axis] * kReach, 1e-4);
  EXPECT_EQ(stick.force()[0], 0.25);
}

TEST(ForceStick, IsCutAtWhatTheDeviceCanDo) {
  FakeFirmware firmware(FakeModel::pid_18);
  ForceStick stick(firmware, kReach, kFull, start_pose());
  HandWrench wrench = HandWrench::Constant(1e6);
  wrench[1] = NAN;
  for (int n = 0; n < 20; ++n) {
    read_at(stick, firmware, n * 1e-3);
    stick.render(wrench);
  }
  EXPECT_CLOSE(firmware.force()[0], 1, 1e-4);
  EXPECT_NEAR(firmware.force()[1], 0, 2e-2);
}

TEST(ForceStick, LostWhetherReadOrWrittenItIsLost) {
  for (const bool read_first : {true, false}) {
    FakeFirmware firmware(FakeModel::pid_18);
    ForceStick stick(firmware, kReach, kFull, start_pose());
    const HandSample before = read_at(stick, firmware, 0.001);
    EXPECT_FALSE(before.finished);
    firmware.unplug();
    if (!read_first)
      for (int n = 0; n < 60; ++n) stick.render(HandWrench::Constant(0.1 * n));
    const HandSample after = stick.read(0.002);
    EXPECT_TRUE(after.lost);
    EXPECT_TRUE(after.finished);
    EXPECT_EQ(after.pose, before.pose);
  }
}

TEST(ForceStick, AButtonEndsTheEpisode) {
  FakeFirmware firmware(FakeModel::pid_22);
  ForceStick stick(firmware, kReach, kFull, start_pose());
  EXPECT_FALSE(read_at(stick, firmware, 0.001).finished);
  firmware.press(4);
  const HandSample sample = read_at(stick, firmware, 0.002);
  EXPECT_TRUE(sample.finished);
  EXPECT_FALSE(sample.lost);
}

// One that reports at rest too, every 1 ms, is missed when it does not.
TEST(ForceStick, OneThatReportsAtRestIsNotTrustedInItsSilence) {
  FakeFirmware firmware(FakeModel::pid_22);
  ForceStick stick(firmware, kReach, kFull, start_pose());
  int n = 0;
  for (; n < 3000; ++n) {
    firmware.deflect({n < 1500 ? 0 : n, 0, 0, 0, 0, 0});
    ASSERT_EQ(read_at(stick, firmware, n * 1e-3).age, 0) << n;
  }
  firmware.fall_silent(true);
  const double last = (n - 1) * 1e-3;
  for (; n < 3500; ++n) {
    const double silence = n * 1e-3 - last;
    const double age = read_at(stick, firmware, n * 1e-3).age;
    if (silence < ForceStick::kSilence - 1e-3) {
      ASSERT_EQ(age, 0) << n;
    }
    if (silence > ForceStick::kSilence + 2e-3) {
      ASSERT_NEAR(age, silence, 2e-3) << n;
    }
  }
  firmware.fall_silent(false);
  EXPECT_EQ(read_at(stick, firmware, 3.6).age, 0);
}

// One that reports only what is new may be silent for as long as it likes, however long it moved.
TEST(ForceStick, OneThatReportsWhenItMovesMayRest) {
  FakeFirmware firmware(FakeModel::pid_22);
  ForceStick stick(firmware, kReach, kFull, start_pose());
  for (int n = 0; n < 20000; ++n) {
    const bool moves = n < 5000 || (n > 9000 && n < 12000);
    firmware.fall_silent(!moves);
    firmware.deflect({n, 0, 0, 0, 0, 0});
    ASSERT_EQ(read_at(stick, firmware, n * 1e-3).age, 0) << n;
  }
}

// Repeats now and then, as of one that is asked to say every half second that it is there.
TEST(ForceStick, OneThatRepeatsItselfSeldomMayRest) {
  FakeFirmware firmware(FakeModel::pid_22);
  ForceStick stick(firmware, kReach, kFull, start_pose());
  for (int n = 0; n < 20000; ++n) {
    firmware.fall_silent(n > 15000 || n % 500 != 0);
    ASSERT_EQ(read_at(stick, firmware, n * 1e-3).age, 0) << n;
  }
}

// Of 10 bits, as older sticks have them: 50 mm in 512 steps.
TEST(ForceStick, ItsStepFollowsFromItsDescriptor) {
  HidInfo info = FakeFirmware::describe(FakeModel::pid_22);
  EXPECT_CLOSE(force_stick_step(info, kReach), kReach / 32767, 1e-12);
  const std::array<std::uint8_t, 3> high = {0x26, 0xFF, 0x7F};  // 32767; its first two are axes'
  const auto at =
      std::search(info.descriptor.begin(), info.descriptor.end(), high.begin(), high.end());
  ASSERT_NE(at, info.descriptor.end());
  at[1] = 0x00, at[2] = 0x04;                                  // 1024
  const std::array<std::uint8_t, 3> low = {0x16, 0x01, 0x80};  // -32767
  const auto from = std::search(info.descriptor.begin(), at, low.begin(), low.end());
  ASSERT_NE(from, at);
  from[1] = from[2] = 0;
  EXPECT_CLOSE(force_stick_step(info, kReach), kReach / 512, 1e-12);
}

// A device that takes 7 ms for each report, its own time going on meanwhile.
class SlowFirmware : public FakeFirmware {
 public:
  SlowFirmware() : FakeFirmware(FakeModel::pid_22) {}
  bool write(std::span<const std::uint8_t> report) noexcept override {
    std::this_thread::sleep_for(std::chrono::milliseconds(7));
    pass();
    return FakeFirmware::write(report);
  }
  void pass() { advance(std::chrono::duration<double>(Clock::now() - begin_).count()); }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point begin_ = Clock::now();
};

// Effects end in the device's time: where reports hold up the periods, that is not the loop's.
TEST(ForceStick, ADeviceThatHoldsUpTheLoopKeepsItsForce) {
  SlowFirmware firmware;
  ForceStick stick(firmware, kReach, kFull, start_pose());
  for (int n = 0; n < 80; ++n) {  // each longer than 7 ms
    stick.read(n * 1e-3);
    stick.render(HandWrench::Constant(1 + 0.01 * n));
    firmware.pass();
    if (n > 5) {
      ASSERT_NE(firmware.force()[0], 0) << n;
    }
  }
}

}  // namespace
}  // namespace ferrule
