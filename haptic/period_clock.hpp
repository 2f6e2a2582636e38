// A loop of a fixed period: absolute deadlines, so that lateness of one period does not move the
// next (clock_nanosleep, TIMER_ABSTIME, CLOCK_MONOTONIC), and the statistics of what became of it.
#pragma once

#include <array>
#include <cstdint>

namespace ferrule {

// Times between the wake-ups of successive periods [s].
struct PeriodStatistics {
  std::uint64_t periods = 0;
  double p50 = 0, p99 = 0, p99_9 = 0;  // percentiles, rounded up to a thousandth of the period
  double worst = 0;
  std::uint64_t missed = 0;  // deadlines at which the loop was still at work, or still asleep
};

// Counts in bins of a thousandth of a period, the last one for all beyond eight periods. Fixed
// size, for any number of periods.
class PeriodHistogram {
 public:
  explicit PeriodHistogram(double period) noexcept : period_(period) {}  // [s], > 0

  void add(double interval) noexcept;  // [s], >= 0
  // Without `missed`.
  PeriodStatistics statistics() const noexcept;

 private:
  double period_;
  std::uint64_t count_ = 0;
  double worst_ = 0;
  std::array<std::uint32_t, 8001> bins_{};
};

class PeriodClock {
 public:
  explicit PeriodClock(double period) noexcept;  // [s], >= 1e-6

  // Sleeps until the next deadline; the first call sets it, one period from now. Deadlines that
  // have gone by already count as missed and are left out. Returns the time since the last wake-up
  // [s]. Does not allocate.
  double wait() noexcept;

  // To be asked when the work of the last period ends: deadlines that have gone by since its own,
  // overslept or outlasted, count as missed too.
  PeriodStatistics statistics() const noexcept;

 private:
  std::int64_t outlasted(std::int64_t time) const noexcept;

  std::int64_t period_;                       // [ns]
  std::int64_t deadline_ = 0, previous_ = 0;  // [ns] on the clock; previous_ is the last wake-up
  std::uint64_t missed_ = 0;
  PeriodHistogram histogram_;
};

}  // namespace ferrule
