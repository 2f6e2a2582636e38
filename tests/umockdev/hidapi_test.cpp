// The real hidapi against the firmware model, through libumockdev: a fake /sys and /dev, in which
// reads, writes and ioctls of /dev/hidrawN are answered by haptic/hid/fake_firmware.hpp. To be run
// under umockdev-wrapper; elsewhere it says so and ends with 77 (skipped).
#include <gtest/gtest.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <umockdev.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <mutex>
#include <thread>

#include "haptic/hid/device_list.hpp"
#include "haptic/hid/fake_firmware.hpp"
#include "haptic/hid/force_stick.hpp"
#include "haptic/hid/space_mouse.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

using Bytes = std::vector<std::uint8_t>;

std::string g_program;  // ferrule, from the command line

// One firmware behind /dev/hidrawN, served by a thread of its own.
class Node {
 public:
  Node(UMockdevTestbed* testbed, FakeModel model, int number)
      : testbed_(testbed), firmware_(model), path_("/dev/hidraw" + std::to_string(number)) {
    add(testbed, FakeFirmware::describe(model), number);
    context_ = g_main_context_new();
    loop_ = g_main_loop_new(context_, FALSE);
    base_ = UMOCKDEV_IOCTL_BASE(g_object_new(UMOCKDEV_TYPE_IOCTL_BASE, nullptr));
    g_signal_connect(base_, "handle-ioctl", G_CALLBACK(&Node::on_ioctl), this);
    g_signal_connect(base_, "handle-read", G_CALLBACK(&Node::on_read), this);
    g_signal_connect(base_, "handle-write", G_CALLBACK(&Node::on_write), this);
    g_main_context_push_thread_default(context_);
    GError* error = nullptr;
    EXPECT_TRUE(umockdev_testbed_attach_ioctl(testbed, path_.c_str(), base_, &error));
    g_main_context_pop_thread_default(context_);
    // The node is a terminal; a line in it that nobody takes lets poll() say "readable" for ever,
    // and each read comes here.
    const int terminal = umockdev_testbed_get_dev_fd(testbed, path_.c_str());
    EXPECT_EQ(::write(terminal, "\n", 1), 1);
    thread_ = std::thread([this] {
      g_main_context_push_thread_default(context_);
      g_main_loop_run(loop_);
      g_main_context_pop_thread_default(context_);
    });
  }
  ~Node() {
    umockdev_testbed_detach_ioctl(testbed_, path_.c_str(), nullptr);
    g_main_loop_quit(loop_);
    thread_.join();
    g_object_unref(base_);
    g_main_loop_unref(loop_);
    g_main_context_unref(context_);
  }

  // A device of the kernel's HID bus and its hidraw node.
  static void add(UMockdevTestbed* testbed, const HidInfo& info, int number) {
    const std::string node = "hidraw" + std::to_string(number);
    char hid[32], id[32];
    std::snprintf(hid, sizeof hid, "0003:%04X:%04X.%04X", info.vendor, info.product, number + 1);
    std::snprintf(id, sizeof id, "0003:%08X:%08X", info.vendor, info.product);
    std::string text = std::string("P: /devices/") + hid + "\nE: SUBSYSTEM=hid\nE: HID_ID=" + id +
                       "\nE: HID_NAME=" + info.name +
                       "\nE: HID_PHYS=usb-1/input0\nE: HID_UNIQ=\nH: report_descriptor=";
    for (const std::uint8_t byte : info.descriptor) {
      char hex[3];
      std::snprintf(hex, sizeof hex, "%02X", byte);
      text += hex;
    }
    text += std::string("\n\nP: /devices/") + hid + "/hidraw/" + node + "\nN: " + node +
            "\nE: DEVNAME=/dev/" + node + "\nE: SUBSYSTEM=hidraw\nL: device=../../../" + hid + "\n";
    GError* error = nullptr;
    ASSERT_TRUE(umockdev_testbed_add_from_string(testbed, text.c_str(), &error)) << error->message;
  }

  // The firmware, alone.
  template <class Do>
  auto with(Do&& act) {
    const std::lock_guard lock(mutex_);
    return act(firmware_);
  }

 private:
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self) {
    const gulong request = umockdev_ioctl_client_get_request(client);
    const gsize size = _IOC_SIZE(request);
    UMockdevIoctlData* const data =
        umockdev_ioctl_data_resolve(umockdev_ioctl_client_get_arg(client), 0, size, nullptr);
    const std::lock_guard lock(self->mutex_);
    FakeFirmware& firmware = self->firmware_;
    const std::span bytes(data->data, size);
    if (request == HIDIOCGRDESCSIZE) {
      const int length = static_cast<int>(firmware.info().descriptor.size());
      umockdev_ioctl_data_update(data, 0,
                                 const_cast<guint8*>(reinterpret_cast<const guint8*>(&length)), 4);
      umockdev_ioctl_client_complete(client, 0, 0);
    } else if (request == HIDIOCSFEATURE(size)) {
      const bool taken = firmware.send_feature(bytes);
      umockdev_ioctl_client_complete(client, taken ? static_cast<glong>(size) : -1,
                                     taken ? 0 : EPIPE);
    } else if (request == HIDIOCGFEATURE(size)) {
      Bytes answer(bytes.begin(), bytes.end());
      const int length = firmware.get_feature(answer);
      umockdev_ioctl_data_update(data, 0, answer.data(), static_cast<gint>(size));
      umockdev_ioctl_client_complete(client, length, length < 0 ? EPIPE : 0);
    } else {
      umockdev_ioctl_client_complete(client, -1, ENOTTY);
    }
    umockdev_ioctl_data_unref(data);
    return TRUE;
  }

  static gboolean on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self) {
    UMockdevIoctlData* const data = umockdev_ioctl_client_get_arg(client);
    const std::lock_guard lock(self->mutex_);
    Bytes report(static_cast<std::size_t>(data->data_len));
    const int length = self->firmware_.read(report, 0);
    if (length > 0) umockdev_ioctl_data_update(data, 0, report.data(), length);
    umockdev_ioctl_client_complete(client, length > 0 ? length : -1,
                                   length > 0   ? 0
                                   : length < 0 ? EIO
                                                : EAGAIN);
    return TRUE;
  }

  static gboolean on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self) {
    const UMockdevIoctlData* const data = umockdev_ioctl_client_get_arg(client);
    const auto size = static_cast<std::size_t>(data->data_len);
    const std::lock_guard lock(self->mutex_);
    const bool taken = self->firmware_.write(std::span(data->data, size));
    umockdev_ioctl_client_complete(client, taken ? data->data_len : -1, taken ? 0 : EPIPE);
    return TRUE;
  }

  UMockdevTestbed* testbed_;
  std::mutex mutex_;
  FakeFirmware firmware_;
  std::string path_;
  GMainContext* context_;
  GMainLoop* loop_;
  UMockdevIoctlBase* base_;
  std::thread thread_;
};

class Hidapi : public ::testing::Test {
 protected:
  ~Hidapi() override { g_object_unref(testbed_); }
  UMockdevTestbed* testbed_ = umockdev_testbed_new();
};

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

double seconds() {
  static const auto kBegin = std::chrono::steady_clock::now();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - kBegin).count();
}

// What became of a run of the program's record with a device.
struct Ran {
  int status;  // of wait
  std::string output;
  bool file;    // is the first episode there?
  double felt;  // the largest force along X
  double left;  // the largest that is there after the program's end and two lives of an effect
};

// Runs it while the firmware's time passes with the clock's. `hand` acts on the firmware, given the
// time since the program enabled the motors; `signal` is sent to the program 2.5 s after that.
Ran record(Node& node, int signal, const std::function<void(FakeFirmware&, double)>& hand,
           const std::string& more = "") {
  const testing::TemporaryFolder folder;
  Ran ran{};
  node.with([](FakeFirmware& f) {  // just switched on, at rest
    f.write(Bytes{0x1C, 0x08});
    f.deflect({});
    f.press(0);
    f.advance(seconds());
  });
  std::atomic<bool> over = false;
  std::atomic<pid_t> program = 0;
  std::thread clock([&] {
    double enabled = -1;
    bool sent = signal == 0;
    while (!over) {
      node.with([&](FakeFirmware& f) {
        const double now = seconds();
        if (enabled < 0 && program != 0 && f.actuators()) enabled = now;
        if (enabled >= 0) hand(f, now - enabled);
        f.advance(now);
        ran.felt = std::max(ran.felt, std::abs(f.force()[0]));
        if (!sent && enabled >= 0 && now - enabled > 2.5) sent = ::kill(program, signal) == 0;
      });
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  const std::string command =
      "echo $$; exec " + g_program +
      " record --device auto --episodes 2 --set limits.force_uN=1000 --out " + (folder / "out") +
      more + " 2>&1";
  FILE* const pipe = ::popen(command.c_str(), "r");
  for (int c = std::fgetc(pipe); c != EOF; c = std::fgetc(pipe)) {
    ran.output += static_cast<char>(c);
    if (program == 0 && c == '\n') program = std::stoi(ran.output);
  }
  ran.status = ::pclose(pipe);
  ran.file = std::filesystem::exists(folder / "out/episode_0001.h5");
  std::this_thread::sleep_for(std::chrono::duration<double>(2 * ForceOutput::kDuration));
  over = true;
  clock.join();
  const auto left = node.with([](FakeFirmware& f) {
    f.advance(seconds());
    return f.force();
  });
  ran.left = std::max(std::abs(left[0]), std::abs(left[1]));
  return ran;
}

// A button, Ctrl-C, a kill or the cable: there is no force after each of them.
TEST_F(Hidapi, TheProgramRecordsUntilItIsEndedAndLeavesNoForce) {
  ASSERT_FALSE(g_program.empty());
  Node node(testbed_, FakeModel::pid_22, 0);
  const auto stopped = [&] {
    return node.with([](FakeFirmware& f) { return !f.actuators() && f.effects() == 0; });
  };
  // Against the lead-in, and held there.
  const auto hold = [](FakeFirmware& f, double t) {
    f.press(0);
    f.deflect({-static_cast<int>(24000 * std::min(1.0, t / 2)), 0, 0, 0, 0, 0});
  };
  const Ran pressed =
      record(node, 0, [](FakeFirmware& f, double t) { f.press(std::fmod(t, 2.0) > 1.0 ? 1 : 0); });
  EXPECT_EQ(pressed.status, 0) << pressed.output;
  EXPECT_NE(pressed.output.find("stopped_short"), std::string::npos) << pressed.output;
  EXPECT_TRUE(pressed.file);
  EXPECT_TRUE(stopped());

  const Ran interrupted = record(node, SIGINT, hold);
  EXPECT_TRUE(WIFEXITED(interrupted.status) && WEXITSTATUS(interrupted.status) == 130);
  EXPECT_NE(interrupted.output.find("stopped by Ctrl-C"), std::string::npos) << interrupted.output;
  EXPECT_TRUE(interrupted.file) << interrupted.output;
  EXPECT_GT(interrupted.felt, 0.01);
  EXPECT_EQ(interrupted.left, 0);
  EXPECT_TRUE(stopped());

  const Ran killed = record(node, SIGKILL, hold);
  EXPECT_TRUE(WIFSIGNALED(killed.status));
  EXPECT_FALSE(killed.file) << killed.output;
  EXPECT_FALSE(stopped());  // nobody could say stop
  EXPECT_GT(killed.felt, 0.01);
  EXPECT_EQ(killed.left, 0);  // but the effects ended

  const Ran lost = record(node, 0, [](FakeFirmware& f, double t) {
    f.press(0);
    if (t > 1) f.unplug();
  });
  EXPECT_TRUE(WIFEXITED(lost.status) && WEXITSTATUS(lost.status) == 4) << lost.output;
  EXPECT_NE(lost.output.find("the device was lost"), std::string::npos) << lost.output;
  EXPECT_TRUE(lost.file);
}

// The first episode ends by a button, the motors are off: then the cable.
TEST_F(Hidapi, LostBetweenEpisodesTheEarlierOnesAreTold) {
  Node node(testbed_, FakeModel::pid_22, 0);
  const Ran lost = record(
      node, 0,
      [](FakeFirmware& f, double t) {
        f.press(t > 1 ? 1 : 0);
        if ((t > 1 && !f.actuators()) || t > 10) f.unplug();
      },
      " --json");
  EXPECT_TRUE(WIFEXITED(lost.status) && WEXITSTATUS(lost.status) == 4) << lost.output;
  EXPECT_NE(lost.output.find("the device was lost"), std::string::npos) << lost.output;
  EXPECT_NE(lost.output.find("episode_0001.h5"), std::string::npos) << lost.output;
  EXPECT_TRUE(lost.file);
}

TEST_F(Hidapi, LostBeforeTheKeyThatStartsAnEpisodeTheProgramEnds) {
  Node node(testbed_, FakeModel::pid_22, 0);
  const testing::TemporaryFolder folder;
  const std::string out = folder / "out";
  int terminal = -1;
  const pid_t program = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  if (program == 0) {
    ::execl(g_program.c_str(), "ferrule", "record", "--device", "auto", "--out", out.c_str(),
            nullptr);
    ::_exit(1);
  }
  ASSERT_GT(program, 0);
  std::string output;
  pollfd readable{terminal, POLLIN, 0};
  std::array<char, 256> part;
  while (::poll(&readable, 1, 60000) > 0) {
    const ssize_t length = ::read(terminal, part.data(), part.size());
    if (length <= 0) break;  // it has ended
    output.append(part.data(), static_cast<std::size_t>(length));
    if (output.find("space starts") != std::string::npos)
      node.with([](FakeFirmware& f) { f.unplug(); });
  }
  ::kill(program, SIGKILL);  // where it waits for ever
  int status = 0;
  ::waitpid(program, &status, 0);
  ::close(terminal);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 4) << output;
  EXPECT_NE(output.find("the device was lost"), std::string::npos) << output;
  EXPECT_TRUE(std::filesystem::is_empty(out));
}

}  // namespace
}  // namespace ferrule

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) ferrule::g_program = argv[1];
  UMockdevTestbed* const testbed = umockdev_testbed_new();
  ferrule::Node::add(testbed, {}, 0);
  const bool mocked = umockdev_in_mock_environment();  // it needs a device to tell
  g_object_unref(testbed);
  if (!mocked) {
    std::puts("skipped: not run under umockdev-wrapper");
    return 77;
  }
  return RUN_ALL_TESTS();
}
