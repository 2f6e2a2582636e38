#include "haptic/hid/report_descriptor.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "haptic/hid/fake_firmware.hpp"

namespace ferrule {
namespace {

using Bytes = std::vector<std::uint8_t>;
using enum HidReportType;

std::string refusal(const Bytes& bytes) {
  try {
    parse_report_descriptor(bytes);
  } catch (const DeviceTrouble& trouble) {
    return trouble.what();
  }
  return "";
}

// The boot mouse of the HID specification 1.11, appendix E.10.
const Bytes kMouse = {0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0x09, 0x01, 0xA1, 0x00, 0x05, 0x09, 0x19,
                      0x01, 0x29, 0x03, 0x15, 0x00, 0x25, 0x01, 0x95, 0x03, 0x75, 0x01, 0x81, 0x02,
                      0x95, 0x01, 0x75, 0x05, 0x81, 0x01, 0x05, 0x01, 0x09, 0x30, 0x09, 0x31, 0x15,
                      0x81, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x02, 0x81, 0x06, 0xC0, 0xC0};

TEST(ReportDescriptor, OfTheMouseInTheSpecification) {
  const HidDescriptor d = parse_report_descriptor(kMouse);
  EXPECT_EQ(d.usage, 0x10002u);
  EXPECT_FALSE(d.numbered);
  EXPECT_EQ(d.payload(input, 0), 3u);
  EXPECT_EQ(d.payload(output, 0), 0u);
  ASSERT_EQ(d.fields.size(), 5u);  // three buttons, X, Y; the padding is left out
  const HidField& y = *find_field(d, input, 0x10031);
  EXPECT_EQ(y.bit, 16);
  EXPECT_EQ(y.size, 8);
  EXPECT_TRUE(y.variable);
  EXPECT_TRUE(y.relative);
  EXPECT_EQ(y.logical_min, -127);
  EXPECT_EQ(y.logical_max, 127);
  EXPECT_EQ(y.collections, (std::vector<std::uint32_t>{0x10002, 0x10001}));
  EXPECT_EQ(find_field(d, input, 0x90003)->bit, 2);
  const Bytes payload = {0x05, 0xFE, 0x80};
  EXPECT_EQ(get_field(*find_field(d, input, 0x90001), payload), 1);
  EXPECT_EQ(get_field(*find_field(d, input, 0x90002), payload), 0);
  EXPECT_EQ(get_field(*find_field(d, input, 0x90003), payload), 1);
  EXPECT_EQ(get_field(*find_field(d, input, 0x10030), payload), -2);
  EXPECT_EQ(get_field(y, payload), -128);
  EXPECT_EQ(get_field(y, Bytes{0x05, 0xFE}), std::nullopt);
  EXPECT_EQ(find_field(d, input, 0x10032), nullptr);
  EXPECT_EQ(find_field(d, output, 0x10030), nullptr);
  EXPECT_EQ(find_field(d, input, 0x10030, 0xF0021), nullptr);
}

TEST(ReportDescriptor, ArraysPickOneOfTheirUsages) {
  // Report 12, an array of 8 bits with a range of usages; units of 2^-n and pushed states.
  const HidDescriptor d = parse_report_descriptor(Bytes{
      0x05, 0x0F, 0x09, 0x96, 0xA1, 0x02, 0x85, 0x0C, 0xA4, 0x19, 0x97, 0x29, 0x9A, 0x15, 0x01,
      0x25, 0x04, 0x75, 0x08, 0x95, 0x02, 0x55, 0xFD, 0x66, 0x03, 0x10, 0x91, 0x00, 0xB4, 0xC0});
  ASSERT_EQ(d.fields.size(), 1u);
  const HidField& f = d.fields[0];
  EXPECT_FALSE(f.variable);
  EXPECT_EQ(f.type, output);
  EXPECT_EQ(f.report, 12);
  EXPECT_EQ(f.count, 2);
  EXPECT_EQ(f.usages, (std::vector<std::uint32_t>{0xF0097, 0xF0098, 0xF0099, 0xF009A}));
  EXPECT_EQ(f.unit, 0x1003u);
  EXPECT_EQ(f.unit_exponent, -3);
  EXPECT_EQ(get_field(f, Bytes{3, 4}, 1), 4);
  EXPECT_EQ(get_field(f, Bytes{3, 4}, 2), std::nullopt);
}

TEST(ReportDescriptor, AMaximumBelowAMinimumOfZeroHasNoSign) {
  const HidDescriptor d = parse_report_descriptor(
      Bytes{0x05, 0x01, 0x09, 0x30, 0x15, 0x00, 0x26, 0xA0, 0x8C, 0x75, 0x10, 0x95, 0x01, 0x81, 2});
  EXPECT_EQ(d.fields[0].logical_max, 36000);
  EXPECT_EQ(get_field(d.fields[0], Bytes{0xA0, 0x8C}), 36000);
}

TEST(ReportDescriptor, SaysWhereItIsBroken) {
  EXPECT_NE(refusal({0x05}).find("byte 0: the item is cut off"), std::string::npos);
  EXPECT_NE(refusal({0x05, 1, 0x27, 1, 2, 3}).find("byte 2"), std::string::npos);
  EXPECT_NE(refusal({0xFE, 5, 0, 1}).find("cut off"), std::string::npos);
  EXPECT_NE(refusal({0xC0}).find("no collection"), std::string::npos);
  EXPECT_NE(refusal({0xA1, 1}).find("not ended"), std::string::npos);
  EXPECT_NE(refusal({0xB4}).find("pop"), std::string::npos);
  EXPECT_NE(refusal({0x85, 0}).find("report id"), std::string::npos);
  EXPECT_EQ(refusal({0x75, 33, 0x95, 1, 0x81, 2}), "");  // left out
  EXPECT_NE(refusal({0x75, 1, 0x96, 0x01, 0x10, 0x81, 2}).find("4096 fields"), std::string::npos);
  EXPECT_NE(refusal({0x77, 255, 255, 255, 255, 0x97, 255, 255, 255, 255, 0x81, 1}).find("4 kB"),
            std::string::npos);
  EXPECT_NE(refusal(Bytes(17, 0xA4)).find("pushed"), std::string::npos);
  EXPECT_NE(refusal(Bytes(5000, 0)).find("4096 bytes"), std::string::npos);
  EXPECT_EQ(refusal({}), "");
}

// What is put is got, for fields anywhere, and no other bit changes.
TEST(ReportDescriptor, PutAndGetAreAPair) {
  std::mt19937_64 draw(1);
  for (int i = 0; i < 20000; ++i) {
    HidField f;
    f.size = static_cast<std::uint8_t>(1 + draw() % 32);
    f.bit = static_cast<std::uint16_t>(draw() % 90);
    const bool negative = draw() % 2;
    f.logical_min = negative ? -(std::int64_t{1} << (f.size - 1)) : 0;
    f.logical_max = f.logical_min + (std::int64_t{1} << f.size) - 1;
    const auto value = f.logical_min + static_cast<std::int64_t>(draw() % (1ull << f.size));
    Bytes payload(16);
    for (auto& byte : payload) byte = static_cast<std::uint8_t>(draw());
    const Bytes before = payload;
    put_field(f, payload, value);
    ASSERT_EQ(get_field(f, payload), value);
    for (std::size_t bit = 0; bit < 128; ++bit) {
      if (bit >= f.bit && bit < std::size_t{f.bit} + f.size) continue;
      ASSERT_EQ(payload[bit / 8] >> (bit % 8) & 1, before[bit / 8] >> (bit % 8) & 1);
    }
    Bytes shorter(payload.begin(), payload.begin() + 3);
    put_field(f, shorter, value);  // outside: nothing happens
    if (f.bit < 24) continue;
    EXPECT_TRUE(std::equal(shorter.begin(), shorter.end(), before.begin()));
  }
}

// Random bytes and random changes of real descriptors: parsed within its bounds, or refused.
TEST(ReportDescriptor, TakesAnythingOrSaysWhyNot) {
  std::mt19937_64 draw(2);
  int taken = 0, refused = 0;
  std::vector<Bytes> seeds = {kMouse};
  for (const FakeModel model : {FakeModel::space_mouse_split, FakeModel::pid_18, FakeModel::pid_22})
    seeds.push_back(FakeFirmware::describe(model).descriptor);
  for (int i = 0; i < 20000; ++i) {
    Bytes bytes = seeds[draw() % seeds.size()];
    if (i % 4 == 0) {
      bytes.resize(draw() % 300);
      for (auto& byte : bytes) byte = static_cast<std::uint8_t>(draw());
    } else {
      for (std::uint64_t n = 1 + draw() % 4; n > 0; --n)
        bytes[draw() % bytes.size()] = static_cast<std::uint8_t>(draw());
    }
    try {
      const HidDescriptor d = parse_report_descriptor(bytes);
      ++taken;
      ASSERT_LE(d.fields.size(), 4096u);
      for (const HidField& f : d.fields) {
        ASSERT_GE(f.size, 1);
        ASSERT_LE(f.size, 32);
        ASSERT_LE(f.usages.size(), 256u);
        const std::size_t payload = d.payload(f.type, f.report);
        ASSERT_LE(f.bit + std::size_t{f.size} * f.count, 8 * payload);
        ASSERT_TRUE(get_field(f, Bytes(payload, 0xFF)).has_value());
      }
    } catch (const DeviceTrouble& trouble) {
      ++refused;
      ASSERT_TRUE(std::string(trouble.what()).starts_with("report descriptor, byte "));
    }
  }
  EXPECT_GT(taken, 1000);
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace ferrule
