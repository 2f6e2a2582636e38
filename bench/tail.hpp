// The worst steps, not the median: over many random scenes and motions, and over the shipped ones.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct TailRow {
  std::string scene;  // a shipped one, or "random": all random scenes together
  long steps = 0, not_converged = 0, capped = 0;
  int evaluations_p9999 = 0, evaluations_max = 0;  // of the potential, in one step
  // Time of one step. What is longer than some microseconds is measured again, from the same state,
  // and the least counts: the rest is the machine's.
  double p9999_us = 0, worst_us = 0;
  // Hand motions that end where they began, and those in which the fibre gained energy
  // (sim/analysis/hand_work.hpp).
  long loops = 0, loops_that_gained = 0;
};

// Every shipped scene with `scenes` starts in insertions and against the wall, in steps of 1 ms;
// and `scenes` random ones (bench/random_scene.hpp) in all motions, in steps of 0.1 to 10 ms. A
// motion ends where the end tilts by more than 0.5 rad: laws and holder are those of small tilts.
// Drawn under `seed`.
std::vector<TailRow> bench_tail(std::uint64_t seed, std::size_t scenes, const GoOn& go_on = {});

}  // namespace ferrule
