// Does a scene care how it lies about its axis?
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct TurnRow {
  std::string scene, motion;
  // How far from each other the ends are at most, over all starts [clearances]: of the same motion
  // turned about the bore's axis by 90 and by 37 degrees, and mirrored. Starts of which one is off
  // by more than 1e-6.
  double quarter = 0, any = 0, mirrored = 0;
  long starts = 0, off = 0;
};

// Every shipped scene without gravity, in insertions and against the wall, in steps of 1 ms.
std::vector<TurnRow> bench_turns(std::uint64_t seed, std::size_t starts, const GoOn& go_on = {});

}  // namespace ferrule
