// What the machine allows a haptic loop: real-time scheduling, and memory that is not paged out.
#pragma once

namespace ferrule {

// From construction to destruction the calling thread runs under SCHED_FIFO, and the memory that is
// there at construction stays resident, as far as that is permitted.
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

}  // namespace ferrule
