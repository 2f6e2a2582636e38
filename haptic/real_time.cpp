#include "haptic/real_time.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>

namespace ferrule {

RealTime::RealTime(int priority) noexcept {
  sched_param parameters{};
  ::pthread_getschedparam(::pthread_self(), &policy_before_, &parameters);
  priority_before_ = parameters.sched_priority;
  parameters.sched_priority = priority;
  scheduling_error_ = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
  // Not what is allocated later: beyond the limit of locked memory that would fail.
  locking_error_ = ::mlockall(MCL_CURRENT) == 0 ? 0 : errno;
}

RealTime::~RealTime() {
  if (locked()) ::munlockall();
  if (!scheduled()) return;
  sched_param parameters{};
  parameters.sched_priority = priority_before_;
  ::pthread_setschedparam(::pthread_self(), policy_before_, &parameters);
}

}  // namespace ferrule
