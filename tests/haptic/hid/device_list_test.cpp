#include "haptic/hid/device_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "haptic/hid/fake_firmware.hpp"

namespace ferrule {
namespace {

const Driver& kSpaceMouse = *fake_driver("fake:spacemouse");
const Driver& kStick = *fake_driver("fake:pid");

TEST(DeviceList, DriversFollowFromIdsUsageAndDescriptorNotFromNames) {
  HidInfo mouse = FakeFirmware::describe(FakeModel::space_mouse_split);
  EXPECT_EQ(driver_of(mouse), &kSpaceMouse);
  mouse.name = "";
  mouse.product = 0x1234;  // unknown id, but it says multi-axis controller
  EXPECT_EQ(driver_of(mouse), &kSpaceMouse);
  mouse.product = 0xc635;
  mouse.usage_page = mouse.usage = 0;  // known id, no descriptor
  mouse.descriptor.clear();
  EXPECT_EQ(driver_of(mouse), &kSpaceMouse);
  mouse.usage_page = 1;
  mouse.usage = 2;  // another interface of the same device
  EXPECT_EQ(driver_of(mouse), nullptr);

  // A keyboard, and then the axes.
  HidInfo both = FakeFirmware::describe(FakeModel::space_mouse_combined);
  const std::vector<std::uint8_t> keys = {0x05, 0x01, 0x09, 0x06, 0xA1, 0x01, 0xC0};
  both.descriptor.insert(both.descriptor.begin(), keys.begin(), keys.end());
  both.usage_page = 1;
  both.usage = 6;
  EXPECT_EQ(driver_of(both), &kSpaceMouse);

  HidInfo cad = FakeFirmware::describe(FakeModel::space_mouse_split);
  cad.product = 0xc650;
  EXPECT_EQ(driver_of(cad), nullptr);

  HidInfo stick = FakeFirmware::describe(FakeModel::pid_18);
  EXPECT_EQ(driver_of(stick), &kStick);
  stick.descriptor.resize(stick.descriptor.size() - 1);
  EXPECT_EQ(driver_of(stick), nullptr);
  stick.descriptor.clear();
  stick.name = "SpaceMouse with force feedback";
  EXPECT_EQ(driver_of(stick), nullptr);
}

// X, Y and Z of a multi-axis controller.
constexpr std::uint8_t kThreeAxes[] = {0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0x85, 0x01, 0x16,
                                       0xA2, 0xFE, 0x26, 0x5E, 0x01, 0x09, 0x30, 0x09, 0x31,
                                       0x09, 0x32, 0x75, 0x10, 0x95, 0x03, 0x81, 0x02, 0xC0};

TEST(DeviceList, WhatItsDriverCannotUseIsUnusableWithTheReason) {
  HidInfo mouse = FakeFirmware::describe(FakeModel::space_mouse_split);
  EXPECT_EQ(missing(mouse, kSpaceMouse), "");
  mouse.descriptor.assign(std::begin(kThreeAxes), std::end(kThreeAxes));
  EXPECT_EQ(missing(mouse, kSpaceMouse), "");  // the table knows its axes
  mouse.product = 0x1234;
  mouse.path = "/dev/hidraw3";
  ASSERT_EQ(driver_of(mouse), &kSpaceMouse);
  const std::string why = missing(mouse, kSpaceMouse);
  EXPECT_EQ(why, "its report descriptor names no six axes");
  EXPECT_FALSE((FoundDevice{mouse, &kSpaceMouse, true, why}).usable());
  EXPECT_FALSE((FoundDevice{mouse, &kSpaceMouse, false, why}).forbidden());

  HidInfo stick = FakeFirmware::describe(FakeModel::pid_18);
  EXPECT_EQ(missing(stick, kStick), "");
  // Its first X Y Z, which are its input, become Vx Vy Vz.
  const std::array<std::uint8_t, 12> usages = {0x05, 0x01, 0x09, 0x30, 0x05, 0x01,
                                               0x09, 0x31, 0x05, 0x01, 0x09, 0x32};
  const auto at =
      std::search(stick.descriptor.begin(), stick.descriptor.end(), usages.begin(), usages.end());
  ASSERT_NE(at, stick.descriptor.end());
  at[3] = 0x40, at[7] = 0x41, at[11] = 0x42;
  ASSERT_EQ(driver_of(stick), &kStick);
  EXPECT_EQ(missing(stick, kStick), "its report descriptor names no axis X, Y or Z");
}

// OpenFFBoard has commands of its own in front of its forces, with words of 64 bits.
TEST(DeviceList, AMakersOwnWideFieldsHideNoForce) {
  HidInfo stick = FakeFirmware::describe(FakeModel::pid_22);
  const std::vector<std::uint8_t> own = {0x06, 0x00, 0xFF, 0x09, 0x00, 0xA1, 0x01, 0x85, 0x70, 0x09,
                                         0x01, 0x15, 0x00, 0x25, 0x04, 0x75, 0x40, 0x95, 0x01, 0x91,
                                         0x02, 0x75, 0x08, 0x09, 0x02, 0x91, 0x02, 0xC0};
  stick.descriptor.insert(stick.descriptor.begin(), own.begin(), own.end());
  EXPECT_EQ(driver_of(stick), &kStick);
  const HidDescriptor d = parse_report_descriptor(stick.descriptor);
  EXPECT_EQ(d.payload(HidReportType::output, 0x70), 9u);
  EXPECT_EQ(find_field(d, HidReportType::output, 0xFF000002)->bit, 64);
}

// What the table says of a driver holds of its own model.
TEST(DeviceList, EveryDriverDrivesItsModel) {
  for (const Driver& driver : drivers()) {
    const auto model = driver.fake();
    const HidInfo& info = model->info();
    EXPECT_EQ(info.path, driver.fake_name);
    EXPECT_EQ(driver_of(info), &driver) << driver.name;
    EXPECT_EQ(fake_driver(driver.fake_name), &driver);
    EXPECT_EQ(missing(info, driver), "");
    const auto device = driver.make(*model, {{1, 1, 1}, 1, HandPose::Zero()});
    ASSERT_NE(device->mapping(), nullptr);
    model->deflect({300, 0, 0, 0, 0, 0});
    model->advance(0.02);
    EXPECT_GT(device->read(0.02).counts[0], 100) << driver.name;
    EXPECT_TRUE(!driver.force || driver.force->motors(info)[0] == 1) << driver.name;
    EXPECT_TRUE(!driver.force || driver.force->step(info, 1) > 0);
  }
  EXPECT_EQ(fake_driver("fake:else"), nullptr);
}

TEST(DeviceList, TheRuleNamesTheDeviceAsTheKernelDoes) {
  HidInfo info;
  info.vendor = 0x046d;
  info.product = 0xc62b;
  EXPECT_EQ(udev_rule(info), "KERNEL==\"hidraw*\", KERNELS==\"*:046D:C62B.*\", TAG+=\"uaccess\"");
  EXPECT_NE(
      udev_command(info).find("echo '" + udev_rule(info) + "' | sudo tee -a /etc/udev/rules.d/"),
      std::string::npos);
}

}  // namespace
}  // namespace ferrule
