// When a campaign has been long enough: its success rate is known closely, or a target is decided.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "controller/trial.hpp"

namespace ferrule {

struct Verdict {
  enum Kind { undecided, shown, refuted };

  double rate;  // the target, within (0, 1)
  Kind kind;
  std::size_t trials;  // the first trials that decide it, or all; the infeasible count
};
const char* name(Verdict::Kind kind) noexcept;

// Watches trials in their order.
//
// The target is shown once evidence_above reaches 20, and refuted once evidence_below does
// (controller/statistics.hpp). A rate at or below it is shown, and one at or above it refuted, with
// a chance of at most 5 %, however many trials are run and whenever they are looked at.
class Target {
 public:
  explicit Target(double rate) noexcept : verdict_{rate, Verdict::undecided, 0} {}
  void after(const TrialResult& trial);
  const Verdict& verdict() const noexcept { return verdict_; }

 private:
  Verdict verdict_;
  std::size_t successes_ = 0, feasible_ = 0;
};

// Of the first trials that decide it.
Verdict decide(double rate, const std::vector<TrialResult>& trials);

// What there has to be known; nothing: a campaign is as long as was asked for.
struct Enough {
  std::optional<double> width;   // of the 95 % interval (Wilson): narrower than that, > 0
  std::optional<double> target;  // decided
};

// Says after each trial, in their order, whether all of it is known. Looked at after every trial,
// the interval covers the rate a little less often than 95 times in 100.
std::function<bool(const TrialResult&)> when(const Enough& enough);

}  // namespace ferrule
