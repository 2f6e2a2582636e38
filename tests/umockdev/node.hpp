// A hidraw node with the firmware model behind it, through libumockdev: a fake /sys and /dev, in
// which reads, writes and ioctls of /dev/hidrawN are answered by haptic/hid/fake_firmware.hpp. Only
// under umockdev-wrapper.
#pragma once

#include <gtest/gtest.h>
#include <umockdev.h>

#include <mutex>
#include <string>
#include <thread>

#include "haptic/hid/fake_firmware.hpp"

namespace ferrule::testing {

// Serves the node in a thread of its own.
class Node {
 public:
  Node(UMockdevTestbed* testbed, FakeModel model, int number);
  ~Node();

  // A device of the kernel's HID bus and its hidraw node, with nobody behind it.
  static void add(UMockdevTestbed* testbed, const HidInfo& info, int number);

  // The firmware, alone.
  template <class Do>
  auto with(Do&& act) {
    const std::lock_guard lock(mutex_);
    return act(firmware_);
  }

 private:
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self);
  static gboolean on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self);
  static gboolean on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self);

  UMockdevTestbed* testbed_;
  std::mutex mutex_;
  FakeFirmware firmware_;
  std::string path_;
  GMainContext* context_;
  GMainLoop* loop_;
  UMockdevIoctlBase* base_;
  std::thread thread_;
};

// A machine without devices.
class Testbed : public ::testing::Test {
 protected:
  ~Testbed() override { g_object_unref(testbed_); }
  UMockdevTestbed* testbed_ = umockdev_testbed_new();
};

}  // namespace ferrule::testing
