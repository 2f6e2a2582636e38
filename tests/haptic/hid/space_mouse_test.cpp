#include "haptic/hid/space_mouse.hpp"

#include "haptic/hid/fake_firmware.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr double kSpeed = 6e-3, kTilt = 1e-3, kPoll = 1e-3;

HandPose at(double x, double y, double z) {
  HandPose pose;
  pose << x, y, z, 1e-3, -2e-3;
  return pose;
}

// Runs the device until t [s] and returns its last sample.
HandSample run(SpaceMouse& mouse, FakeFirmware& firmware, double from, double to) {
  HandSample sample;
  const auto first = std::llround(from / kPoll), last = std::llround(to / kPoll);
  for (auto n = first; n <= last; ++n) {
    firmware.advance(static_cast<double>(n) * kPoll);
    sample = mouse.read(static_cast<double>(n) * kPoll);
  }
  return sample;
}

TEST(SpaceMouse, KnowsItsIdsAndWhatIsNeverOne) {
  EXPECT_EQ(space_mouse_layout(0x046d, 0xc626), SpaceMouseLayout::split);
  EXPECT_EQ(space_mouse_layout(0x046d, 0xc62b), SpaceMouseLayout::split);
  EXPECT_EQ(space_mouse_layout(0x256f, 0xc635), SpaceMouseLayout::split);
  EXPECT_EQ(space_mouse_layout(0x256f, 0xc62e), SpaceMouseLayout::combined);
  EXPECT_EQ(space_mouse_layout(0x256f, 0xc652), SpaceMouseLayout::combined);
  EXPECT_EQ(space_mouse_layout(0x046d, 0xc62a), std::nullopt);
  EXPECT_EQ(space_mouse_layout(0x1234, 0xc635), std::nullopt);
  for (int id = 0; id < 0x10000; ++id) {
    const auto product = static_cast<std::uint16_t>(id);
    EXPECT_FALSE(never_a_space_mouse(0x256f, product) && space_mouse_layout(0x256f, product));
    EXPECT_FALSE(never_a_space_mouse(0x046d, product));
  }
  for (const std::uint16_t id : {0xc650, 0xc651, 0xc654, 0xc658, 0xc62c, 0xc664, 0xc665, 0xc668})
    EXPECT_TRUE(never_a_space_mouse(0x256f, id));
}

TEST(SpaceMouse, AxesComeFromTheDescriptorAndElseFromTheTable) {
  HidInfo info = FakeFirmware::describe(FakeModel::space_mouse_combined);
  info.product = 0xc635;  // the table says split: the descriptor is believed
  EXPECT_EQ(space_mouse_axes(info).places()[5].field.report, 1);
  info.descriptor.resize(info.descriptor.size() / 2);  // broken
  EXPECT_EQ(space_mouse_axes(info).places()[5].field.report, 2);
  info.descriptor.clear();
  EXPECT_EQ(space_mouse_axes(info).places()[5].field.report, 2);
  info.product = 0x1;
  EXPECT_THROW(space_mouse_axes(info), DeviceTrouble);
}

// Full deflection along each axis moves the hand as it is seen: X to the right is out of the bore.
TEST(SpaceMouse, DeflectionIsAVelocity) {
  const struct {
    std::size_t axis;
    int pose;
    double rate;
  } kCases[] = {{0, 0, kSpeed}, {2, 1, -kSpeed}, {1, 2, kSpeed}, {4, 3, kTilt}, {5, 4, kTilt}};
  for (const FakeModel model : {FakeModel::space_mouse_split, FakeModel::space_mouse_combined})
    for (const auto& [axis, pose, rate] : kCases)
      for (const int sign : {1, -1}) {
        FakeFirmware firmware(model);
        const HandPose start = at(0.01, -0.02, 0.03);
        SpaceMouse mouse(firmware, kSpeed, kTilt, start);
        ASSERT_EQ(mouse.mapping()->kind, Mapping::Kind::velocity);
        std::array<int, 6> counts{};
        counts[axis] = sign * 350;
        EXPECT_EQ(run(mouse, firmware, 0, 0.019).pose, start);
        firmware.deflect(counts);
        const HandPose moved = run(mouse, firmware, 0.02, 1.02).pose - start;
        for (int k = 0; k < 5; ++k)  // a report comes every 16 ms at least
          EXPECT_NEAR(moved[k] / rate, k == pose ? sign * 1.0 : 0.0, 0.017) << axis;
      }
}

TEST(SpaceMouse, EveryTickMovesByWhatItsCountsSay) {
  FakeFirmware firmware(FakeModel::space_mouse_split);
  SpaceMouse mouse(firmware, kSpeed, kTilt, at(0, 0, 0));
  HandSample before;
  for (int n = 0; n < 2000; ++n) {
    const double t = n * kPoll;
    firmware.deflect({n % 700 - 350, 200 - n / 5, n % 97, -n % 350, n % 31, 340});
    firmware.advance(t);
    const HandSample now = mouse.read(t);
    if (n > 0) {
      const HandTwist rate = mouse.mapping()->gain * mouse.mapping()->deflection(before.counts);
      EXPECT_LT((now.pose - before.pose - kPoll * rate).norm(), 1e-15);
    }
    before = now;
  }
  EXPECT_GT(before.pose.norm(), 1e-4);
}

TEST(SpaceMouse, CountsBeyondTheDeclaredRangeAreCutAndSmallOnesAreDead) {
  const Mapping m = space_mouse_mapping(AxisReader::space_mouse(true), kSpeed, kTilt);
  RawCounts counts;
  counts << 350, 498, -498, -350, 17, 18;
  const auto d = m.deflection(counts);
  EXPECT_EQ(d[0], 1);
  EXPECT_EQ(d[1], 1);
  EXPECT_EQ(d[2], -1);
  EXPECT_EQ(d[3], -1);
  EXPECT_EQ(d[4], 0);                                    // 17 of 350 is less than 5 %
  EXPECT_NEAR(d[5], (18 / 350.0 - 0.05) / 0.95, 1e-12);  // and it begins at 0
  // Rising, odd, continuous.
  double before = -1;
  for (int c = -498; c <= 498; ++c) {
    const double now = m.deflection(RawCounts::Constant(c))[0];
    EXPECT_GE(now, before);
    EXPECT_LE(now - before, 1.0 / 300);
    EXPECT_EQ(now, -m.deflection(RawCounts::Constant(-c))[0]);
    before = now;
  }
}

TEST(SpaceMouse, SilenceAfterADeflectionStopsTheHand) {
  for (const FakeModel model : {FakeModel::space_mouse_split, FakeModel::space_mouse_combined}) {
    FakeFirmware firmware(model);
    SpaceMouse mouse(firmware, kSpeed, kTilt, at(0, 0, 0));
    firmware.deflect({-350, 0, 0, 0, 350, 0});
    const HandSample moving = run(mouse, firmware, 0, 0.2);
    EXPECT_LT(moving.pose[0], -1e-3);
    firmware.fall_silent(true);
    const HandSample soon = run(mouse, firmware, 0.201, 0.201 + SpaceMouse::kSilence + 0.002);
    EXPECT_EQ(soon.counts, RawCounts::Zero());
    EXPECT_GE(mouse.faults(), 1);
    const HandSample later = run(mouse, firmware, 0.26, 1.0);
    EXPECT_EQ(later.pose, soon.pose);
    EXPECT_FALSE(later.finished);
    firmware.fall_silent(false);
    EXPECT_LT(run(mouse, firmware, 1.001, 1.2).pose[0], later.pose[0]);  // it goes on
  }
}

TEST(SpaceMouse, RestIsNoFault) {
  for (const FakeModel model : {FakeModel::space_mouse_split, FakeModel::space_mouse_combined}) {
    FakeFirmware firmware(model);
    SpaceMouse mouse(firmware, kSpeed, kTilt, at(0, 0, 0));
    firmware.deflect({100, 100, 100, 100, 100, 100});
    run(mouse, firmware, 0, 0.2);
    firmware.deflect({});
    const HandSample rested = run(mouse, firmware, 0.201, 0.3);
    EXPECT_EQ(run(mouse, firmware, 0.301, 2.0).pose, rested.pose);
    EXPECT_EQ(mouse.faults(), 0);
  }
}

TEST(SpaceMouse, AButtonEndsTheEpisodeUnlessItWasHeldBefore) {
  FakeFirmware firmware(FakeModel::space_mouse_split);
  firmware.press(1);
  SpaceMouse mouse(firmware, kSpeed, kTilt, at(0, 0, 0));
  EXPECT_TRUE(firmware.light());
  EXPECT_FALSE(run(mouse, firmware, 0, 0.1).finished);
  firmware.press(0);
  EXPECT_FALSE(run(mouse, firmware, 0.101, 0.2).finished);
  firmware.press(2);
  const HandSample sample = mouse.read(0.201);
  EXPECT_TRUE(sample.finished);
  EXPECT_FALSE(sample.lost);
}

TEST(SpaceMouse, UnpluggedItEndsTheEpisodeWhereItIs) {
  FakeFirmware firmware(FakeModel::space_mouse_split);
  SpaceMouse mouse(firmware, kSpeed, kTilt, at(0, 0, 0));
  firmware.deflect({-350, 0, 0, 0, 0, 0});
  run(mouse, firmware, 0, 0.2);
  firmware.unplug();
  const HandSample lost = mouse.read(0.201);
  EXPECT_TRUE(lost.finished);
  EXPECT_TRUE(lost.lost);
  EXPECT_EQ(lost.counts, RawCounts::Zero());
  EXPECT_EQ(mouse.read(0.3).pose, lost.pose);
}

TEST(SpaceMouse, PutsTheLightOut) {
  FakeFirmware firmware(FakeModel::space_mouse_split);
  { SpaceMouse mouse(firmware, kSpeed, kTilt, at(0, 0, 0)); }
  EXPECT_FALSE(firmware.light());
  EXPECT_EQ(firmware.log().front().bytes, (std::vector<std::uint8_t>{0x04, 0x01}));
}

}  // namespace
}  // namespace ferrule
