// Why a step took as many evaluations as it did: what each stage decided, in order. For whoever
// mends the solver (`ferrule replay EPISODE --trace TIME`); a step without a trace pays nothing.
#pragma once

#include <vector>

namespace ferrule {

// In the order in which a step goes through them (sim/solver/step.cpp).
enum class SolverStage {
  extrapolation,  // without an evaluation, along the tangent
  free_flight,    // without an evaluation, in free air
  predictor,      // from the linearization of the step before
  corrector,      // the prediction is evaluated
  newton,         // an iteration of Newton's method
  friction,       // a Newton step in friction limits and pose together
  accepted,       // the end of the sub-step is the new state
  rejected,       // the sub-step was too long and is divided
};
inline constexpr const char* kStageNames[] = {"extrapolation", "free flight", "predictor",
                                              "corrector",     "Newton",      "friction",
                                              "accepted",      "rejected"};

struct TraceEntry {
  SolverStage stage;
  const char* decision;  // and why
  double part;           // of the command's path, where the sub-step ends [-]
  int evaluations;       // of the potential, in this sub-step so far
  double residual;       // over the sum of all forces [-]; NaN where nothing was evaluated
  double move;  // of the end in this stage, over the clearance [-]; NaN where none was made
};

class StepTrace {
 public:
  void clear() { entries_.clear(); }
  void add(const TraceEntry& entry) { entries_.push_back(entry); }
  const std::vector<TraceEntry>& entries() const { return entries_; }

  double part = 1;  // of the sub-step that is being solved

 private:
  std::vector<TraceEntry> entries_;
};

}  // namespace ferrule
