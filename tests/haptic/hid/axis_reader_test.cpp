#include "haptic/hid/axis_reader.hpp"

#include <gtest/gtest.h>

#include <random>

#include "haptic/hid/fake_firmware.hpp"
#include "haptic/hid/space_mouse.hpp"

namespace ferrule {
namespace {

using Bytes = std::vector<std::uint8_t>;

RawCounts counts(int x, int y, int z, int rx, int ry, int rz) {
  RawCounts c;
  c << x, y, z, rx, ry, rz;
  return c;
}

// Reports captured from devices: by the table and by the descriptor.
TEST(AxisReader, ReadsCapturedReportsOfTheSplitLayout) {
  const HidInfo info = FakeFirmware::describe(FakeModel::space_mouse_split);
  for (AxisReader reader : {AxisReader::space_mouse(false), space_mouse_axes(info)}) {
    EXPECT_EQ(reader.axes(), 6);
    EXPECT_EQ(reader.take(Bytes{0x02, 0x00, 0x00, 0xe2, 0xff, 0x00, 0x00}), 2);
    EXPECT_EQ(reader.counts(), counts(0, 0, 0, 0, -30, 0));
    EXPECT_EQ(reader.take(Bytes{0x01, 0x12, 0x00, 0x00, 0x00, 0xf8, 0x00}), 1);
    EXPECT_EQ(reader.counts(), counts(18, 0, 248, 0, -30, 0));
    EXPECT_EQ(reader.take(Bytes{0x02, 0x20, 0x00, 0x00, 0x00, 0x17, 0x00}), 2);
    EXPECT_EQ(reader.counts(), counts(18, 0, 248, 32, 0, 23));
    EXPECT_EQ(reader.buttons(), 0u);
    EXPECT_EQ(reader.take(Bytes{0x03, 0x01, 0x00}), 3);
    EXPECT_EQ(reader.buttons(), 1u);
    EXPECT_EQ(reader.take(Bytes{0x03, 0x02, 0x00}), 3);
    EXPECT_EQ(reader.buttons(), 2u);
    EXPECT_EQ(reader.take(Bytes{0x17, 0x64}), -1);  // battery
    EXPECT_EQ(reader.counts(), counts(18, 0, 248, 32, 0, 23));
    EXPECT_TRUE(reader.centre(1));
    EXPECT_FALSE(reader.centre(1));
    EXPECT_EQ(reader.counts(), counts(0, 0, 0, 32, 0, 23));
  }
}

TEST(AxisReader, CountsReportsThatSayNothingNew) {
  AxisReader reader = AxisReader::space_mouse(false);
  const Bytes still = {0x01, 0x12, 0x00, 0x00, 0x00, 0xf8, 0x00}, button = {0x03, 0x01, 0x00};
  for (const Bytes& report : {still, still, button, still, still, Bytes{0x17, 0x64}, still})
    reader.take(report);
  EXPECT_EQ(reader.reports(), 6);
  EXPECT_EQ(reader.repeats(), 3);  // the battery's is none of these
}

TEST(AxisReader, ReadsACapturedReportOfTheCombinedLayout) {
  const HidInfo info = FakeFirmware::describe(FakeModel::space_mouse_combined);
  for (AxisReader reader : {AxisReader::space_mouse(true), space_mouse_axes(info)}) {
    EXPECT_EQ(reader.take(Bytes{0x01, 0, 0, 0, 0, 0x01, 0, 0, 0, 0, 0, 0, 0}), 1);
    EXPECT_EQ(reader.counts(), counts(0, 0, 1, 0, 0, 0));
    EXPECT_EQ(reader.take(Bytes{0x01, 0, 0, 0, 0, 0, 0, 0xa2, 0xfe, 0, 0, 0x5e, 0x01}), 1);
    EXPECT_EQ(reader.counts(), counts(0, 0, 0, -350, 0, 350));
  }
}

TEST(AxisReader, ReadsAStickWithoutReportIdsOffItsCentre) {
  // X and Y from 0 to 1023 in 10 bits each, then four buttons.
  const HidDescriptor d = parse_report_descriptor(
      Bytes{0x05, 0x01, 0x09, 0x04, 0xA1, 0x01, 0x09, 0x30, 0x09, 0x31, 0x15, 0x00,
            0x26, 0xFF, 0x03, 0x75, 0x0A, 0x95, 0x02, 0x81, 0x02, 0x05, 0x09, 0x19,
            0x01, 0x29, 0x04, 0x25, 0x01, 0x75, 0x01, 0x95, 0x04, 0x81, 0x02, 0xC0});
  AxisReader reader(d);
  EXPECT_EQ(reader.axes(), 2);
  EXPECT_EQ(reader.counts(), counts(511, 511, 0, 0, 0, 0));
  EXPECT_EQ(reader.take(Bytes{0xFF, 0x03, 0x80}), 0);
  EXPECT_EQ(reader.counts(), counts(1023, 0, 0, 0, 0, 0));
  EXPECT_EQ(reader.buttons(), 8u);
}

// The mouse in front of a multi-axis controller has an X of its own.
TEST(AxisReader, TakesTheAxesOfTheMultiAxisControllerWhereThereIsOne) {
  Bytes bytes = {0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x85, 0x07, 0x09, 0x30, 0x15,
                 0x81, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x01, 0x81, 0x06, 0xC0};
  const Bytes controller = FakeFirmware::describe(FakeModel::space_mouse_combined).descriptor;
  bytes.insert(bytes.end(), controller.begin(), controller.end());
  AxisReader reader(parse_report_descriptor(bytes));
  EXPECT_EQ(reader.axes(), 6);
  EXPECT_EQ(reader.take(Bytes{0x07, 0x50}), -1);
  EXPECT_EQ(reader.counts(), counts(0, 0, 0, 0, 0, 0));
}

TEST(AxisReader, LeavesOutAnAxisThatIsWiderThanItsCounts) {
  for (const std::uint8_t top : {0x7F, 0xFF}) {
    const Bytes bytes = {0x05, 0x01, 0x09, 0x04, 0xA1, 0x01, 0x17, 0x00, 0x00,
                         0x00, 0x70, 0x27, 0xFF, 0xFF, 0xFF, top,  0x09, 0x30,
                         0x75, 0x20, 0x95, 0x01, 0x81, 0x02, 0xC0};
    EXPECT_EQ(AxisReader(parse_report_descriptor(bytes)).axes(), top == 0x7F);
  }
}

TEST(AxisReader, IgnoresReportsThatAreTooShort) {
  AxisReader reader = AxisReader::space_mouse(false);
  EXPECT_EQ(reader.take(Bytes{}), -1);
  EXPECT_EQ(reader.take(Bytes{0x01}), -1);
  EXPECT_EQ(reader.take(Bytes{0x01, 0x12}), -1);
  EXPECT_EQ(reader.take(Bytes{0x01, 0x12, 0x00, 0x07}), 1);  // X is whole
  EXPECT_EQ(reader.counts(), counts(18, 0, 0, 0, 0, 0));
}

// Whatever bytes come: counts are 16-bit numbers of the bytes, and nothing else.
TEST(AxisReader, TakesAnyBytes) {
  std::mt19937_64 draw(3);
  AxisReader split = AxisReader::space_mouse(false), combined = AxisReader::space_mouse(true);
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes(draw() % 20);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(draw());
    if (!bytes.empty()) bytes[0] = static_cast<std::uint8_t>(draw() % 5);
    const RawCounts before = combined.counts();
    const int id = combined.take(bytes);
    split.take(bytes);
    for (const AxisReader& reader : {split, combined}) {
      ASSERT_LE(reader.counts().maxCoeff(), 32767);
      ASSERT_GE(reader.counts().minCoeff(), -32768);
    }
    if (id == 1) {
      ASSERT_EQ(combined.counts()[0], static_cast<std::int16_t>(bytes[1] | bytes[2] << 8));
    } else {
      ASSERT_EQ(combined.counts(), before);
    }
  }
}

}  // namespace
}  // namespace ferrule
