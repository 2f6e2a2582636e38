// The hard cases: where simulators of this kind blow up, hang or lie. tests/hard/README.md says
// what is right in each and why.
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct HardRow {
  std::string name;
  double step_s;        // step in time, or NaN where there is none
  std::string result;   // what came out
  double error;         // against what is right, relative unless the result says otherwise
  double tolerance;     // error above it fails
  bool finite;          // no value was ever NaN or infinite
  bool gained = false;  // the hand's closed motion got more work out than it put in
  bool passed() const { return finite && !gained && error <= tolerance; }
};

std::vector<HardRow> bench_hard(const GoOn& go_on = {});

}  // namespace ferrule
