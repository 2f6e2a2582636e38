// The real hidapi, and the drivers on it, against the firmware model.
#include <cerrno>
#include <cmath>
#include <cstring>

#include "haptic/hid/device_list.hpp"
#include "haptic/hid/force_stick.hpp"
#include "haptic/hid/space_mouse.hpp"
#include "tests/umockdev/node.hpp"

namespace ferrule {
namespace {

using testing::Node;
using Bytes = std::vector<std::uint8_t>;
using Hidapi = testing::Testbed;

TEST_F(Hidapi, AMachineWithoutDevicesHasNone) {
  EXPECT_TRUE(list_hid().empty());
  EXPECT_THROW(choose_device("auto"), DeviceTrouble);
}

TEST_F(Hidapi, DevicesAreFoundByIdUsageAndDescriptor) {
  Node::add(testbed_, FakeFirmware::describe(FakeModel::space_mouse_split), 0);
  Node::add(testbed_, FakeFirmware::describe(FakeModel::pid_22), 1);
  HidInfo cad = FakeFirmware::describe(FakeModel::space_mouse_split);
  cad.product = 0xc650;
  Node::add(testbed_, cad, 2);
  HidInfo mouse = {"", 0x046d, 0xc077, 1, 2, "mouse", {0x05, 0x01, 0x09, 0x02, 0xA1, 0x01, 0xC0}};
  Node::add(testbed_, mouse, 3);

  const std::vector<HidInfo> all = list_hid();
  ASSERT_EQ(all.size(), 4u);
  const HidInfo described = FakeFirmware::describe(FakeModel::space_mouse_split);
  EXPECT_EQ(all[0].path, "/dev/hidraw0");
  EXPECT_EQ(all[0].vendor, 0x256f);
  EXPECT_EQ(all[0].product, 0xc635);
  EXPECT_EQ(all[0].usage_page, 1);
  EXPECT_EQ(all[0].usage, 8);
  EXPECT_EQ(all[0].name, described.name);
  EXPECT_EQ(all[0].descriptor, described.descriptor);

  const std::vector<FoundDevice> found = find_devices();
  ASSERT_EQ(found.size(), 3u);  // not the mouse
  EXPECT_EQ(found[0].driver, fake_driver("fake:spacemouse"));
  EXPECT_EQ(found[1].driver, fake_driver("fake:pid"));
  EXPECT_EQ(found[2].driver, nullptr);
  EXPECT_EQ(choose_device("auto").info.path, "/dev/hidraw0");
  EXPECT_EQ(choose_device("/dev/hidraw1").driver, fake_driver("fake:pid"));
  EXPECT_THROW(choose_device("/dev/hidraw2"), DeviceTrouble);
  EXPECT_THROW(choose_device("/dev/hidraw3"), DeviceTrouble);
  EXPECT_THROW(choose_device("/dev/hidraw9"), DeviceTrouble);
}

TEST_F(Hidapi, ADeviceWithoutItsAxesIsPassedOver) {
  HidInfo three = FakeFirmware::describe(FakeModel::space_mouse_split);
  three.product = 0x1234;
  three.descriptor = {0x05, 0x01, 0x09, 0x08, 0xA1, 0x01, 0x85, 0x01, 0x09, 0x30, 0x15,
                      0x00, 0x25, 0x7F, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02, 0xC0};
  Node::add(testbed_, three, 0);
  const std::vector<FoundDevice> found = find_devices();
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].usable());
  for (const char* path : {"auto", "/dev/hidraw0"}) {
    try {
      choose_device(path);
      ADD_FAILURE() << path;
    } catch (const DeviceTrouble& trouble) {
      EXPECT_STREQ(trouble.what(), "/dev/hidraw0: its report descriptor names no six axes");
    }
  }
  Node::add(testbed_, FakeFirmware::describe(FakeModel::pid_22), 1);
  EXPECT_EQ(choose_device("auto").info.path, "/dev/hidraw1");
}

// A node that opens, but is no HID device; and none at all.
TEST_F(Hidapi, WhatCannotBeOpenedSaysWhy) {
  HidInfo info = FakeFirmware::describe(FakeModel::pid_22);
  Node::add(testbed_, info, 0);
  for (const auto& [path, error] : {std::pair{"/dev/hidraw0", ENOTTY}, {"/dev/hidraw7", ENOENT}}) {
    info.path = path;
    try {
      open_hid(info);
      ADD_FAILURE() << path;
    } catch (const DeviceTrouble& trouble) {
      EXPECT_EQ(trouble.what(), info.path + ": cannot be opened: " + std::strerror(error));
    }
  }
}

TEST_F(Hidapi, NodesComeAndGo) {
  for (int n = 0; n < 200; ++n) const Node node(testbed_, FakeModel::pid_22, n);
}

TEST_F(Hidapi, ReportsArriveOneByOne) {
  Node node(testbed_, FakeModel::space_mouse_split, 0);
  const auto device = open_hid(choose_device("auto").info);
  Bytes report(64);
  EXPECT_EQ(device->read(report, 0), 0);
  node.with([](FakeFirmware& f) {
    f.deflect({18, 0, 248, 32, 0, 23});
    f.advance(0.008);
  });
  ASSERT_EQ(device->read(report, 10), 7);
  EXPECT_EQ(Bytes(report.begin(), report.begin() + 7),
            (Bytes{0x01, 0x12, 0x00, 0x00, 0x00, 0xf8, 0x00}));
  ASSERT_EQ(device->read(report, 10), 7);
  EXPECT_EQ(Bytes(report.begin(), report.begin() + 7),
            (Bytes{0x02, 0x20, 0x00, 0x00, 0x00, 0x17, 0x00}));
  EXPECT_EQ(device->read(report, 0), 0);
  EXPECT_TRUE(device->write(Bytes{0x04, 0x01}));
  EXPECT_TRUE(node.with([](FakeFirmware& f) { return f.light(); }));
  EXPECT_FALSE(device->write(Bytes{0x04, 0x01, 0x02}));  // refused
  node.with([](FakeFirmware& f) { f.unplug(); });
  EXPECT_EQ(device->read(report, 10), -1);
  EXPECT_FALSE(device->write(Bytes{0x04, 0x00}));
}

TEST_F(Hidapi, TheWholeLifeOfAnEffectIsByteExact) {
  for (const FakeModel model : {FakeModel::pid_18, FakeModel::pid_22}) {
    const int number = static_cast<int>(model);
    Node node(testbed_, model, number);
    const auto device = open_hid(choose_device("/dev/hidraw" + std::to_string(number)).info);
    FakeFirmware twin(model);  // the same calls without hidapi between
    {
      ForceOutput output(*device), same(twin);
      for (int n = 0; n < 200; ++n) {
        const double t = 1e-3 * n;
        node.with([&](FakeFirmware& f) { f.advance(t); });
        twin.advance(t);
        const std::array<double, 2> force = {std::sin(0.1 * n), 0.5};
        ASSERT_TRUE(output.update(t, force));
        ASSERT_TRUE(same.update(t, force));
      }
      EXPECT_NEAR(node.with([](FakeFirmware& f) { return f.force()[1]; }), 0.5, 0.013);
    }
    node.with([&](FakeFirmware& f) {
      EXPECT_EQ(f.force()[1], 0);
      EXPECT_EQ(f.effects(), 0);
      EXPECT_FALSE(f.actuators());
      ASSERT_EQ(f.log().size(), twin.log().size());
      for (std::size_t i = 0; i < f.log().size(); ++i) {
        EXPECT_EQ(f.log()[i].type, twin.log()[i].type) << i;
        EXPECT_EQ(f.log()[i].bytes, twin.log()[i].bytes) << i;
      }
    });
  }
}

TEST_F(Hidapi, UnpluggedInTheMiddleTheDriversSaySo) {
  Node stick_node(testbed_, FakeModel::pid_18, 0),
      mouse_node(testbed_, FakeModel::space_mouse_combined, 1);
  const auto stick_device = open_hid(choose_device("/dev/hidraw0").info);
  const auto mouse_device = open_hid(choose_device("/dev/hidraw1").info);
  ForceStick stick(*stick_device, 0.05, 8, HandPose::Zero());
  SpaceMouse mouse(*mouse_device, 6e-3, 1e-3, HandPose::Zero());
  HandPose before = HandPose::Zero();
  for (int n = 0; n < 100; ++n) {
    const double t = 1e-3 * n;
    for (Node* node : {&stick_node, &mouse_node})
      node->with([&](FakeFirmware& f) {
        f.deflect({-300, 0, 0, 0, 0, 0});
        f.advance(t);
      });
    ASSERT_FALSE(stick.read(t).lost);
    stick.render(HandWrench::Constant(1));
    before = mouse.read(t).pose;
  }
  EXPECT_LT(before[0], -1e-4);
  for (Node* node : {&stick_node, &mouse_node}) node->with([](FakeFirmware& f) { f.unplug(); });
  EXPECT_TRUE(stick.read(0.1).lost);
  EXPECT_TRUE(mouse.read(0.1).lost);
  EXPECT_EQ(mouse.read(0.2).pose, mouse.read(0.3).pose);
}

}  // namespace
}  // namespace ferrule
