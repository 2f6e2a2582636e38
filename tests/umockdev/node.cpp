#include "tests/umockdev/node.hpp"

#include <linux/hidraw.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace ferrule::testing {

Node::Node(UMockdevTestbed* testbed, FakeModel model, int number)
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

Node::~Node() {
  umockdev_testbed_detach_ioctl(testbed_, path_.c_str(), nullptr);
  // From within: a loop that has not begun yet would not hear it.
  GSource* const quit = g_idle_source_new();
  g_source_set_callback(
      quit,
      [](gpointer loop) -> gboolean {
        g_main_loop_quit(static_cast<GMainLoop*>(loop));
        return G_SOURCE_REMOVE;
      },
      loop_, nullptr);
  g_source_attach(quit, context_);
  g_source_unref(quit);
  thread_.join();
  g_object_unref(base_);
  g_main_loop_unref(loop_);
  g_main_context_unref(context_);
}

void Node::add(UMockdevTestbed* testbed, const HidInfo& info, int number) {
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

gboolean Node::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self) {
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
    std::vector<std::uint8_t> answer(bytes.begin(), bytes.end());
    const int length = firmware.get_feature(answer);
    umockdev_ioctl_data_update(data, 0, answer.data(), static_cast<gint>(size));
    umockdev_ioctl_client_complete(client, length, length < 0 ? EPIPE : 0);
  } else {
    umockdev_ioctl_client_complete(client, -1, ENOTTY);
  }
  umockdev_ioctl_data_unref(data);
  return TRUE;
}

gboolean Node::on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self) {
  UMockdevIoctlData* const data = umockdev_ioctl_client_get_arg(client);
  const std::lock_guard lock(self->mutex_);
  std::vector<std::uint8_t> report(static_cast<std::size_t>(data->data_len));
  const int length = self->firmware_.read(report, 0);
  if (length > 0) umockdev_ioctl_data_update(data, 0, report.data(), length);
  umockdev_ioctl_client_complete(client, length > 0 ? length : -1,
                                 length > 0   ? 0
                                 : length < 0 ? EIO
                                              : EAGAIN);
  return TRUE;
}

gboolean Node::on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, Node* self) {
  const UMockdevIoctlData* const data = umockdev_ioctl_client_get_arg(client);
  const auto size = static_cast<std::size_t>(data->data_len);
  const std::lock_guard lock(self->mutex_);
  const bool taken = self->firmware_.write(std::span(data->data, size));
  umockdev_ioctl_client_complete(client, taken ? data->data_len : -1, taken ? 0 : EPIPE);
  return TRUE;
}

}  // namespace ferrule::testing
