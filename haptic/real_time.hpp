// What the machine allows a haptic loop: real-time scheduling, memory that is not paged out, and
// the devices themselves.
#pragma once

#include <string>
#include <vector>

namespace ferrule {

// From construction to destruction the calling thread runs under SCHED_FIFO and all memory stays
// resident, as far as that is permitted.
class RealTime {
 public:
  // `priority` from 1 to 99.
  explicit RealTime(int priority = 80) noexcept;
  ~RealTime();
  RealTime(const RealTime&) = delete;
  RealTime& operator=(const RealTime&) = delete;

  bool scheduled() const noexcept { return scheduling_error_ == 0; }
  bool locked() const noexcept { return locking_error_ == 0; }
  // Why not: errno of the refusal, 0 where granted.
  int scheduling_error() const noexcept { return scheduling_error_; }
  int locking_error() const noexcept { return locking_error_; }

 private:
  int scheduling_error_, locking_error_;
  int policy_before_ = 0, priority_before_ = 0;
};

// One /dev/hidrawN.
struct HidrawNode {
  std::string path;
  int vendor = 0, product = 0;  // USB ids; 0 where unknown
  bool allowed = false;         // may this process read and write it?
};

// Those of this machine, sorted by path.
std::vector<HidrawNode> hidraw_nodes();

// The udev rule that gives the user at the seat a device: for its ids, or for all hidraw devices
// where these are 0.
std::string udev_rule(int vendor, int product);

}  // namespace ferrule
