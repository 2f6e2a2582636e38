#include "haptic/real_time.hpp"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <fstream>

namespace ferrule {

RealTime::RealTime(int priority) noexcept {
  sched_param parameters{};
  ::pthread_getschedparam(::pthread_self(), &policy_before_, &parameters);
  priority_before_ = parameters.sched_priority;
  parameters.sched_priority = priority;
  scheduling_error_ = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
  locking_error_ = ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0 ? 0 : errno;
}

RealTime::~RealTime() {
  if (locked()) ::munlockall();
  if (!scheduled()) return;
  sched_param parameters{};
  parameters.sched_priority = priority_before_;
  ::pthread_setschedparam(::pthread_self(), policy_before_, &parameters);
}

std::vector<HidrawNode> hidraw_nodes() {
  namespace fs = std::filesystem;
  std::vector<HidrawNode> nodes;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator("/dev", error)) {
    const std::string name = entry.path().filename();
    if (name.rfind("hidraw", 0) != 0) continue;
    HidrawNode node;
    node.path = entry.path();
    node.allowed = ::access(node.path.c_str(), R_OK | W_OK) == 0;
    std::ifstream about("/sys/class/hidraw/" + name + "/device/uevent");
    unsigned bus = 0, vendor = 0, product = 0;
    for (std::string line; std::getline(about, line);)
      if (std::sscanf(line.c_str(), "HID_ID=%x:%x:%x", &bus, &vendor, &product) == 3) {
        node.vendor = static_cast<int>(vendor);
        node.product = static_cast<int>(product);
      }
    nodes.push_back(node);
  }
  std::sort(nodes.begin(), nodes.end(),
            [](const HidrawNode& a, const HidrawNode& b) { return a.path < b.path; });
  return nodes;
}

std::string udev_rule(int vendor, int product) {
  std::string match = "KERNEL==\"hidraw*\", SUBSYSTEM==\"hidraw\"";
  if (vendor != 0)
    match += fmt::format(", ATTRS{{idVendor}}==\"{:04x}\", ATTRS{{idProduct}}==\"{:04x}\"", vendor,
                         product);
  return match + ", MODE=\"0660\", TAG+=\"uaccess\"";
}

}  // namespace ferrule
