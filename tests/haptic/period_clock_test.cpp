#include "haptic/period_clock.hpp"

#include <pthread.h>
#include <signal.h>
#include <sys/time.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "haptic/real_time.hpp"
#include "sim/base/random.hpp"
#include "tests/allocations.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

double now() {
  timespec t;
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

void work(double seconds) {
  const double end = now() + seconds;
  while (now() < end) {
  }
}

TEST(PeriodHistogram, PercentilesAreThoseOfTheSortedTimes) {
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    RandomStream random(9, trial, Draw::start);
    const double period = 1e-3;
    PeriodHistogram histogram(period);
    std::vector<double> times;
    for (int i = 0; i < 5000; ++i) {
      times.push_back(period * -std::log(random.uniform()));  // some beyond the last bin
      histogram.add(times.back());
    }
    std::sort(times.begin(), times.end());
    const PeriodStatistics s = histogram.statistics();
    EXPECT_EQ(s.periods, times.size());
    EXPECT_EQ(s.worst, times.back());
    for (const auto& [value, share] : {std::pair(s.p50, 0.5), {s.p99, 0.99}}) {
      const double exact = times[static_cast<std::size_t>(share * 5000) - 1];
      EXPECT_GE(value, exact * (1 - 1e-12));
      EXPECT_LE(value, exact + 1.001e-3 * period);
    }
    EXPECT_LE(s.p99, s.p99_9);
    EXPECT_LE(s.p99_9, s.worst);
  }
}

TEST(PeriodHistogram, BeyondItsLastBinIsTheWorst) {
  PeriodHistogram histogram(1e-3);
  for (int i = 0; i < 10; ++i) histogram.add(1.0 + i);
  EXPECT_EQ(histogram.statistics().p50, 10.0);
  EXPECT_EQ(PeriodHistogram(1e-3).statistics().p99, 0);
}

TEST(PeriodClock, NeverWakesBeforeItsDeadlines) {
  const double period = 0.5e-3;
  PeriodClock clock(period);
  const double begin = now();
  for (int n = 1; n <= 100; ++n) {
    clock.wait();
    EXPECT_GE(now() - begin, n * period * (1 - 1e-6)) << "late ones do not move the next";
  }
  EXPECT_EQ(clock.statistics().periods, 100u);
}

TEST(PeriodClock, CountsTheDeadlinesThatWorkOutlasted) {
  const double period = 1e-3;
  PeriodClock clock(period);
  clock.wait();
  for (int n = 0; n < 5; ++n) {
    work(3.5 * period);  // past at least three deadlines
    clock.wait();
  }
  const PeriodStatistics s = clock.statistics();
  EXPECT_EQ(s.periods, 6u);
  EXPECT_GE(s.missed, 15u);
  EXPECT_GE(s.worst, 3.5 * period);
}

TEST(PeriodClock, CountsTheDeadlinesThatTheLastWorkOutlasted) {
  const double period = 1e-3;
  PeriodClock clock(period);
  clock.wait();
  work(3.5 * period);
  EXPECT_GE(clock.statistics().missed, 3u);
  EXPECT_EQ(PeriodClock(period).statistics().missed, 0u);
}

// A signal that comes while it sleeps, and takes 70 ms.
TEST(PeriodClock, CountsTheDeadlinesThatItOverslept) {
  const double period = 0.02;
  PeriodClock clock(period);
  clock.wait();
  struct sigaction action {};
  struct sigaction before {};
  action.sa_handler = [](int) { work(0.07); };
  ASSERT_EQ(::sigaction(SIGALRM, &action, &before), 0);
  itimerval once{};
  once.it_value.tv_usec = 5000;
  ASSERT_EQ(::setitimer(ITIMER_REAL, &once, nullptr), 0);
  clock.wait();
  ::sigaction(SIGALRM, &before, nullptr);
  const PeriodStatistics s = clock.statistics();
  EXPECT_GE(s.missed, 2u);
  EXPECT_GE(s.worst, 0.07);
}

TEST(PeriodClock, DoesNotAllocate) {
  PeriodClock clock(1e-4);
  const auto before = testing::allocations();
  for (int n = 0; n < 50; ++n) clock.wait();
  EXPECT_EQ(testing::allocations(), before);
}

TEST(RealTime, IsGivenBackWhenItEnds) {
  const auto policy = [] {
    sched_param p{};
    int which = -1;
    ::pthread_getschedparam(::pthread_self(), &which, &p);
    return std::pair(which, p.sched_priority);
  };
  const auto before = policy();
  {
    const RealTime real_time(10);
    EXPECT_EQ(policy().first == SCHED_FIFO, real_time.scheduled());
    EXPECT_EQ(real_time.scheduled(), real_time.scheduling_error() == 0);
  }
  EXPECT_EQ(policy(), before);
}

}  // namespace
}  // namespace ferrule
