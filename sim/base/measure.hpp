// Timing, of benchmarks and of what a controller costs, and what stands for a figure there is not.
#pragma once

#include <algorithm>
#include <chrono>
#include <ctime>
#include <limits>

namespace ferrule {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Keeps the compiler from dropping what computes `value`.
template <class T>
void keep(const T& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

// How long this thread has run [s]: what others do meanwhile is not counted.
inline double thread_seconds() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

// Nanoseconds per call of `f(i)`, i = 0, 1, ..., the least of five rounds of at least `round_ns`.
template <class F>
double nanoseconds_per_call(const F& f, double round_ns = 10e6) {
  using Clock = std::chrono::steady_clock;
  long calls = 16;
  double best = 1e300;
  for (int round = 0; round < 5;) {
    const auto begin = Clock::now();
    for (long i = 0; i < calls; ++i) f(i);
    const double ns = std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
    if (ns < round_ns) {
      calls *= 2;
      continue;
    }
    best = std::min(best, ns / static_cast<double>(calls));
    ++round;
  }
  return best;
}

}  // namespace ferrule
