#include "haptic/hid/force_output.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "haptic/hid/fake_firmware.hpp"

namespace ferrule {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr double kTick = 1e-3;
constexpr FakeModel kModels[] = {FakeModel::pid_18, FakeModel::pid_22};

double at(int n) {
  return n * kTick;
}

void run(ForceOutput& output, FakeFirmware& firmware, int from, int to,
         const std::array<double, 2>& force) {
  for (int n = from; n <= to; ++n) {
    firmware.advance(at(n));
    ASSERT_TRUE(output.update(at(n), force));
  }
}

TEST(ForceOutput, TheMotorsDoWhatIsAskedAlongBothAxes) {
  for (const FakeModel model : kModels) {
    FakeFirmware firmware(model);
    ForceOutput output(firmware);
    EXPECT_EQ(output.axes(), 2);
    EXPECT_EQ(firmware.effects(), 2);
    int n = 0;
    for (const auto& [x, y] : {std::pair{1.0, 0.0}, {-1.0, 0.5}, {0.25, -1.0}, {0.0, 0.0}}) {
      run(output, firmware, n, n + 20, {x, y});
      n += 21;
      // 8-bit directions are off by up to 0.7 degrees.
      EXPECT_NEAR(firmware.force()[0], x, 0.013);
      EXPECT_NEAR(firmware.force()[1], y, 0.013);
    }
    run(output, firmware, n, n + 20, {7.0, -NAN});
    EXPECT_NEAR(firmware.force()[0], 1, 0.013);
    EXPECT_NEAR(firmware.force()[1], 0, 0.013);
  }
}

TEST(ForceOutput, AForceIsHeldAsLongAsItIsAskedFor) {
  for (const FakeModel model : kModels) {
    FakeFirmware firmware(model);
    ForceOutput output(firmware);
    run(output, firmware, 0, 10, {0.5, -0.5});
    for (int n = 11; n < 2000; ++n) {
      firmware.advance(at(n));
      ASSERT_NEAR(firmware.force()[0], 0.5, 0.013) << n;
      ASSERT_NEAR(firmware.force()[1], -0.5, 0.013) << n;
      ASSERT_TRUE(output.update(at(n), {0.5, -0.5}));
    }
  }
}

// Nobody says stop: the force ends all the same.
TEST(ForceOutput, IfTheProgramDiesTheForceEndsWithTheEffects) {
  for (const FakeModel model : kModels) {
    FakeFirmware firmware(model);
    ForceOutput output(firmware);
    run(output, firmware, 0, 500, {1, 1});
    firmware.advance(at(500) + ForceOutput::kDuration - ForceOutput::kAgain - 2 * kTick);
    EXPECT_NEAR(firmware.force()[0], 1, 0.013);
    firmware.advance(at(500) + ForceOutput::kDuration);
    EXPECT_EQ(firmware.force()[0], 0);
    EXPECT_EQ(firmware.force()[1], 0);
  }
  EXPECT_GE(ForceOutput::kDuration, 0.1);
  EXPECT_LE(ForceOutput::kDuration, 0.2);
}

TEST(ForceOutput, WritesOneReportATickAndStartsEffectsAgainInTime) {
  FakeFirmware firmware(FakeModel::pid_18);
  ForceOutput output(firmware);
  std::array<double, 3> started = {0, 0, 0};
  for (int n = 0; n < 3000; ++n) {
    firmware.advance(at(n));
    const std::size_t before = firmware.log().size();
    ASSERT_TRUE(output.update(at(n), {std::sin(0.01 * n), std::cos(0.02 * n)}));
    ASSERT_LE(firmware.log().size() - before, 1u);
    if (firmware.log().size() == before) continue;
    const Bytes& sent = firmware.log().back().bytes;
    if (sent[0] != 0x0A) continue;
    double& last = started[sent[1]];
    EXPECT_LE(at(n) - last, 0.05);
    if (n > 100) {
      EXPECT_GE(at(n) - last, 0.02);
    }
    last = at(n);
  }
  EXPECT_GT(started[1], 2.9);
  EXPECT_GT(started[2], 2.9);
}

// In the same tick along both axes, whatever else is due.
TEST(ForceOutput, NoForceWaitsForNothing) {
  for (const FakeModel model : kModels)
    for (int end = 100; end < 140; ++end) {
      FakeFirmware firmware(model);
      ForceOutput output(firmware);
      for (int n = 0; n < end; ++n) run(output, firmware, n, n, {0.5 + 1e-3 * n, -0.5});
      ASSERT_NE(firmware.force()[0], 0);
      run(output, firmware, end, end, {end % 2 ? 0.0 : double(NAN), 0.0});
      ASSERT_EQ(firmware.force()[0], 0) << end;
      ASSERT_EQ(firmware.force()[1], 0) << end;
      run(output, firmware, end + 1, end + 300, {0.25, 0});
      EXPECT_NEAR(firmware.force()[0], 0.25, 0.013);  // and it comes back
    }
}

void expect_safe(const FakeFirmware& firmware) {
  EXPECT_EQ(firmware.force()[0], 0);
  EXPECT_EQ(firmware.force()[1], 0);
  EXPECT_FALSE(firmware.actuators());
  EXPECT_EQ(firmware.effects(), 0);
}

TEST(ForceOutput, EveryWayOutLeavesTheDeviceWithoutForce) {
  for (const FakeModel model : kModels) {
    FakeFirmware firmware(model);
    {
      ForceOutput output(firmware);
      run(output, firmware, 0, 50, {1, 1});
    }
    expect_safe(firmware);
    try {
      ForceOutput output(firmware);
      run(output, firmware, 51, 100, {1, 1});
      throw std::runtime_error("something");
    } catch (const std::runtime_error&) {
    }
    expect_safe(firmware);
    ForceOutput output(firmware);
    run(output, firmware, 101, 150, {1, 1});
    output.stop();
    expect_safe(firmware);
    const std::size_t sent = firmware.log().size();
    EXPECT_FALSE(output.update(at(151), {1, 1}));
    output.stop();
    EXPECT_EQ(firmware.log().size(), sent);
  }
}

// The captured way down, for each of two effects.
TEST(ForceOutput, StopsInTheCapturedOrder) {
  FakeFirmware firmware(FakeModel::pid_18);
  ForceOutput output(firmware);
  run(output, firmware, 0, 10, {1, 1});
  const std::size_t before = firmware.log().size();
  output.stop();
  const Bytes kExpected[] = {{0x05, 1, 0, 0}, {0x0A, 1, 3, 0}, {0x05, 2, 0, 0},
                             {0x0A, 2, 3, 0}, {0x0C, 3},       {0x0C, 2},
                             {0x0B, 1},       {0x0B, 2},       {0x0C, 4}};
  ASSERT_EQ(firmware.log().size(), before + std::size(kExpected));
  for (std::size_t i = 0; i < std::size(kExpected); ++i)
    EXPECT_EQ(firmware.log()[before + i].bytes, kExpected[i]) << i;
}

TEST(ForceOutput, AnUnpluggedDeviceIsSeenAndBearsItsEnd) {
  FakeFirmware firmware(FakeModel::pid_22);
  ForceOutput output(firmware);
  run(output, firmware, 0, 50, {1, 1});
  firmware.unplug();
  bool there = true;
  for (int n = 51; n < 90 && there; ++n) there = output.update(at(n), {1, 1});
  EXPECT_FALSE(there);  // the next start at the latest
  output.stop();
}

TEST(ForceOutput, AFullMemoryIsSaidAndLeftEmpty) {
  FakeFirmware firmware(FakeModel::pid_18, 1);  // room for one
  try {
    ForceOutput output(firmware);
    FAIL();
  } catch (const DeviceTrouble& trouble) {
    EXPECT_STREQ(trouble.what(), "fake:pid: has no room for another effect");
  }
  expect_safe(firmware);
}

// Some devices say neither success nor failure until they have made the effect.
TEST(ForceOutput, WaitsForADeviceThatIsStillMakingAnEffect) {
  struct Hesitant : FakeFirmware {
    int asked = 0, every;
    explicit Hesitant(int n) : FakeFirmware(FakeModel::pid_18), every(n) {}
    int get_feature(std::span<std::uint8_t> report) noexcept override {
      const int length = FakeFirmware::get_feature(report);
      if (++asked % every != 0) report[1] = report[2] = 0;
      return length;
    }
  };
  Hesitant slow(3), never(1 << 30);
  EXPECT_EQ(ForceOutput(slow).axes(), 2);
  EXPECT_EQ(slow.asked, 6);
  EXPECT_THROW(ForceOutput output(never), DeviceTrouble);
  expect_safe(never);
}

// What a program that was killed left behind does not fill the memory of the next one.
TEST(ForceOutput, StartsFromAReset) {
  FakeFirmware firmware(FakeModel::pid_18, 2);
  const PidReports reports(parse_report_descriptor(firmware.info().descriptor));
  for (int i = 0; i < 2; ++i) firmware.send_feature(reports.create_constant().span());
  EXPECT_EQ(firmware.effects(), 2);
  ForceOutput output(firmware);
  EXPECT_EQ(firmware.effects(), 2);
}

TEST(ForceOutput, RefusesWhatHasNoForceFeedback) {
  FakeFirmware firmware(FakeModel::space_mouse_split);
  try {
    ForceOutput output(firmware);
    FAIL();
  } catch (const DeviceTrouble& trouble) {
    EXPECT_TRUE(std::string(trouble.what()).starts_with("fake:spacemouse: "));
  }
  EXPECT_TRUE(firmware.log().empty());
}

}  // namespace
}  // namespace ferrule
