#include "haptic/period_clock.hpp"

#include <time.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

namespace ferrule {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;
constexpr double kBins = 1000;  // per period

std::int64_t now() noexcept {
  timespec t;
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

void sleep_until(std::int64_t time) noexcept {
  timespec t;
  t.tv_sec = time / kSecond;
  t.tv_nsec = time % kSecond;
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace

void PeriodHistogram::add(double interval) noexcept {
  const double last = static_cast<double>(bins_.size() - 1);
  const double bin = std::min(last, std::floor(interval / period_ * kBins));
  ++bins_[static_cast<std::size_t>(bin)];
  ++count_;
  worst_ = std::max(worst_, interval);
}

PeriodStatistics PeriodHistogram::statistics() const noexcept {
  PeriodStatistics s;
  s.periods = count_;
  s.worst = worst_;
  const auto percentile = [&](double share) {
    const double rank = share * static_cast<double>(count_);
    std::uint64_t below = 0;
    for (std::size_t i = 0; i + 1 < bins_.size(); ++i) {
      below += bins_[i];
      if (static_cast<double>(below) >= rank)
        return std::min(worst_, static_cast<double>(i + 1) / kBins * period_);
    }
    return worst_;
  };
  s.p50 = percentile(0.5);
  s.p99 = percentile(0.99);
  s.p99_9 = percentile(0.999);
  return s;
}

PeriodClock::PeriodClock(double period) noexcept
    : period_(std::llround(period * 1e9)), histogram_(period) {}

// Deadlines after `deadline_` that have gone by at `time`.
std::int64_t PeriodClock::outlasted(std::int64_t time) const noexcept {
  return std::max<std::int64_t>(0, (time - deadline_ - 1) / period_);
}

double PeriodClock::wait() noexcept {
  const std::int64_t done = now();
  if (deadline_ == 0) deadline_ = previous_ = done;
  const std::int64_t gone = outlasted(done);
  missed_ += static_cast<std::uint64_t>(gone);
  deadline_ += (gone + 1) * period_;
  sleep_until(deadline_);
  const std::int64_t woke = now();
  const double since = static_cast<double>(woke - previous_) * 1e-9;
  histogram_.add(since);
  previous_ = woke;
  return since;
}

PeriodStatistics PeriodClock::statistics() const noexcept {
  PeriodStatistics s = histogram_.statistics();
  s.missed = missed_;
  if (deadline_ != 0) s.missed += static_cast<std::uint64_t>(outlasted(now()));
  return s;
}

}  // namespace ferrule
