#include "haptic/hid/pid_reports.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "haptic/hid/fake_firmware.hpp"

namespace ferrule {
namespace {

using Bytes = std::vector<std::uint8_t>;

HidDescriptor descriptor(FakeModel model) {
  return parse_report_descriptor(FakeFirmware::describe(model).descriptor);
}

Bytes bytes(const HidReport& report) {
  return {report.span().begin(), report.span().end()};
}

// Captured from a host and a device with Set Effect of 18 bytes, at full positive force.
TEST(PidReports, AreTheCapturedBytesOfTheLayoutOf18) {
  const PidReports r(descriptor(FakeModel::pid_18));
  EXPECT_EQ(bytes(r.create_constant()), (Bytes{0x05, 0x01, 0x00, 0x00}));
  EXPECT_EQ(r.block_load_request().size, 5u);
  EXPECT_EQ(r.block_load_request().bytes[0], 0x06);
  const PidBlockLoad load = r.block_load(Bytes{0x06, 0x01, 0x01, 0xFF, 0xFF});
  EXPECT_EQ(load.status, PidBlockLoad::Status::success);
  EXPECT_EQ(load.block, 1);
  EXPECT_EQ(bytes(r.set_effect(1, 0, 32.767)),
            (Bytes{0x01, 0x01, 0x01, 0xFF, 0x7F, 0x00, 0x00, 0x00, 0x00, 0xFF, 0x01, 0x04, 0x40,
                   0x00, 0x00, 0x00, 0x00, 0x00}));
  EXPECT_EQ(bytes(r.set_constant_force(1, 1)), (Bytes{0x05, 0x01, 0x10, 0x27}));
  EXPECT_EQ(bytes(r.operation(1, PidOperation::start)), (Bytes{0x0A, 0x01, 0x01, 0x01}));
  EXPECT_EQ(bytes(r.set_constant_force(1, 0)), (Bytes{0x05, 0x01, 0x00, 0x00}));
  EXPECT_EQ(bytes(r.operation(1, PidOperation::stop)), (Bytes{0x0A, 0x01, 0x03, 0x00}));
  EXPECT_EQ(bytes(r.control(PidControl::stop_all)), (Bytes{0x0C, 0x03}));
  EXPECT_EQ(bytes(r.control(PidControl::disable)), (Bytes{0x0C, 0x02}));
  EXPECT_EQ(bytes(r.control(PidControl::enable)), (Bytes{0x0C, 0x01}));
  EXPECT_EQ(bytes(r.control(PidControl::reset)), (Bytes{0x0C, 0x04}));
  EXPECT_EQ(bytes(r.block_free(1).value()), (Bytes{0x0B, 0x01}));
  EXPECT_EQ(bytes(r.full_device_gain().value()), (Bytes{0x0D, 0xFF}));
  EXPECT_EQ(r.axes(), 2);
}

// By hand, from the layout: 150 ms is 96 00, 90 degrees is 9000 = 28 23, and 180 degrees is
// 18000 = 50 46.
TEST(PidReports, FollowTheLayoutOf22) {
  const PidReports r(descriptor(FakeModel::pid_22));
  EXPECT_EQ(bytes(r.create_constant()), (Bytes{0x21, 0x01, 0x00, 0x00}));
  EXPECT_EQ(bytes(r.set_effect(2, 0, 0.15)),
            (Bytes{0x11, 0x02, 0x01, 0x96, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
                   0xFF, 0x01, 0x04, 0x28, 0x23, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00}));
  const Bytes y = bytes(r.set_effect(2, 1, 0.15));
  EXPECT_EQ(y[14], 0x50);
  EXPECT_EQ(y[15], 0x46);
  EXPECT_EQ(bytes(r.set_constant_force(2, 1)), (Bytes{0x15, 0x02, 0xFF, 0x7F}));
  EXPECT_EQ(bytes(r.set_constant_force(2, -1)), (Bytes{0x15, 0x02, 0x00, 0x80}));
  EXPECT_EQ(bytes(r.operation(2, PidOperation::start)), (Bytes{0x1A, 0x02, 0x01, 0x01}));
  // A mask: one bit each.
  EXPECT_EQ(bytes(r.control(PidControl::enable)), (Bytes{0x1C, 0x01}));
  EXPECT_EQ(bytes(r.control(PidControl::disable)), (Bytes{0x1C, 0x02}));
  EXPECT_EQ(bytes(r.control(PidControl::stop_all)), (Bytes{0x1C, 0x04}));
  EXPECT_EQ(bytes(r.control(PidControl::reset)), (Bytes{0x1C, 0x08}));
  EXPECT_EQ(r.block_load(Bytes{0x22, 0x07, 0x01, 0, 0}).block, 7);
}

TEST(PidReports, ForcesAreInProportionAndCutAtTheEnd) {
  const PidReports r(descriptor(FakeModel::pid_18));
  const auto magnitude = [&](double force) {
    const Bytes b = bytes(r.set_constant_force(1, force));
    return static_cast<std::int16_t>(b[2] | b[3] << 8);
  };
  for (int i = -10000; i <= 10000; i += 7) EXPECT_EQ(magnitude(i / 10000.0), i);
  EXPECT_EQ(magnitude(1.5), 10000);
  EXPECT_EQ(magnitude(-1e300), -10000);
  EXPECT_EQ(magnitude(INFINITY), 0);
  EXPECT_EQ(magnitude(NAN), 0);
}

TEST(PidReports, TheAnswerOfTheBlockLoadIsNeverMistaken) {
  const PidReports r(descriptor(FakeModel::pid_18));
  using Status = PidBlockLoad::Status;
  EXPECT_EQ(r.block_load(Bytes{6, 0, 2, 0, 0}).status, Status::full);
  EXPECT_EQ(r.block_load(Bytes{6, 0, 3, 0, 0}).status, Status::error);
  EXPECT_EQ(r.block_load(Bytes{6, 0, 1, 0, 0}).status, Status::error);  // no block
  EXPECT_EQ(r.block_load(Bytes{6, 1, 0, 0, 0}).status, Status::error);
  EXPECT_EQ(r.block_load(Bytes{6, 1}).status, Status::error);
  EXPECT_EQ(r.block_load(Bytes{7, 1, 1, 0, 0}).status, Status::error);
  EXPECT_EQ(r.block_load(Bytes{}).status, Status::error);
}

TEST(PidReports, NamesWhatADeviceLacks) {
  EXPECT_FALSE(PidReports::in(descriptor(FakeModel::space_mouse_split)));
  EXPECT_TRUE(PidReports::in(descriptor(FakeModel::pid_18)));
  HidDescriptor d = descriptor(FakeModel::pid_18);
  std::erase_if(d.fields, [](const HidField& f) { return f.type == HidReportType::feature; });
  EXPECT_TRUE(PidReports::in(d));
  try {
    PidReports reports(d);
    FAIL();
  } catch (const DeviceTrouble& trouble) {
    EXPECT_NE(std::string(trouble.what()).find("Create New Effect"), std::string::npos);
  }
}

// Whatever descriptor a device shows, a report has the length it names, and nothing is written
// past its end.
TEST(PidReports, ServesDamagedDescriptorsOrRefusesThem) {
  std::mt19937_64 draw(4);
  int served = 0;
  for (int i = 0; i < 4000; ++i) {
    Bytes damaged =
        FakeFirmware::describe(i % 2 ? FakeModel::pid_18 : FakeModel::pid_22).descriptor;
    for (std::uint64_t n = 1 + draw() % 3; n > 0; --n)
      damaged[draw() % damaged.size()] = static_cast<std::uint8_t>(draw());
    try {
      const PidReports r(parse_report_descriptor(damaged));
      ++served;
      for (const HidReport& report :
           {r.create_constant(), r.set_effect(1, 0, 0.15), r.set_effect(300, 1, 1e9),
            r.set_constant_force(1, 0.5), r.operation(1, PidOperation::start),
            r.control(PidControl::reset), r.block_load_request()})
        ASSERT_LE(report.size, 65u);
      Bytes answer(5);
      for (auto& byte : answer) byte = static_cast<std::uint8_t>(draw() % 8);
      const PidBlockLoad load = r.block_load(answer);
      if (load.status == PidBlockLoad::Status::success) {
        EXPECT_GT(load.block, 0);
      }
    } catch (const DeviceTrouble&) {
    }
  }
  EXPECT_GT(served, 1000);
}

}  // namespace
}  // namespace ferrule
