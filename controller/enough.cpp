#include "controller/enough.hpp"

#include <array>

#include "controller/statistics.hpp"

namespace ferrule {

const char* name(Verdict::Kind kind) noexcept {
  constexpr std::array kNames = {"undecided", "shown", "refuted"};
  return kNames[kind];
}

void Target::after(const TrialResult& trial) {
  constexpr double kDecides = 20;
  if (verdict_.kind != Verdict::undecided) return;
  ++verdict_.trials;
  if (trial.outcome == Outcome::infeasible) return;
  ++feasible_;
  successes_ += trial.outcome == Outcome::inserted;
  // On the other side of the rate so far the evidence is below 1.
  if (static_cast<double>(successes_) > verdict_.rate * static_cast<double>(feasible_)) {
    if (evidence_above(verdict_.rate, successes_, feasible_) >= kDecides)
      verdict_.kind = Verdict::shown;
  } else if (evidence_below(verdict_.rate, successes_, feasible_) >= kDecides) {
    verdict_.kind = Verdict::refuted;
  }
}

Verdict decide(double rate, const std::vector<TrialResult>& trials) {
  Target target(rate);
  for (const TrialResult& trial : trials) target.after(trial);
  return target.verdict();
}

std::function<bool(const TrialResult&)> when(const Enough& enough) {
  if (!enough.width && !enough.target) return {};
  return [enough, target = Target(enough.target.value_or(0.5)), successes = std::size_t{0},
          feasible = std::size_t{0}](const TrialResult& trial) mutable {
    if (enough.target) target.after(trial);
    feasible += trial.outcome != Outcome::infeasible;
    successes += trial.outcome == Outcome::inserted;
    if (enough.target && target.verdict().kind == Verdict::undecided) return false;
    if (!enough.width) return true;
    if (feasible == 0) return false;
    const Interval interval = wilson(successes, feasible);
    return interval.high - interval.low < *enough.width;
  };
}

}  // namespace ferrule
