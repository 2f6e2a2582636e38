// How an insertion goes and ends: its outcome, and the watch that tells it.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

#include "sim/model/breakdown.hpp"
#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {

enum class Outcome {
  inserted,        // the inserted length reached the scene's success depth
  force_limit,     // the force at the holder exceeded the limit, on the way in
  jam,             // the same, wedged in the bore: touching with end and side at once
  missed,          // the same, with the end on the front face
  timeout,         // time ran out
  buckled,         // the axial load exceeded Euler's load of the free length (clamped-free)
  broken,          // the bending stress exceeded the scene's proof stress
  invalid_output,  // the controller or operator commanded something that is not a finite number
  stopped_short,   // the operator or controller finished before the success depth
  interrupted,     // the operator or user stopped it
  infeasible,      // the drawn fibre does not fit into the drawn bore: no failure of anybody
  gave_up,         // the supervisor of the controller saw no way on
  high_loss,       // deep enough, but the joint loses more than the scene allows
};
inline constexpr int kOutcomes = 13;
const char* name(Outcome outcome) noexcept;
// Throws BadInput if there is no such outcome.
Outcome outcome_from_name(const std::string& name);

struct InsertionSummary {
  double time = 0;           // of the last step [s]
  double reached = -1;       // when the success depth first was [s]; < 0: never
  double touched = -1;       // when the fibre first touched the ferrule [s]; < 0: never
  double outside = 0;        // when the end last was before the entrance [s]
  double peak_force = 0;     // largest force at the holder, weight apart [N]
  double peak_stress = 0;    // largest bending stress of the free length [Pa]
  double friction_work = 0;  // work done against friction [J], >= 0
  double depth = 0;          // inserted length [m]
  double offset = 0;         // distance of the end's centre from the bore's axis [m]
  double tilt = 0;           // angle of the end to it [rad]
  Pose tip = Pose::Zero();   // of the end [m, rad]
  // Steps, and how many of them ended without a minimum (StepStatus::iteration_limit or
  // not_converged).
  std::int64_t steps = 0, unfinished = 0;

  // What an insertion took: until the success depth, or else to its end [s].
  double task_time() const noexcept { return reached < 0 ? time : reached; }
  // How long it took from the first touch until the end was in the bore for good [s].
  double search_time() const noexcept {
    return touched < 0 ? 0.0 : std::max(0.0, outside - touched);
  }
};

// Watches an insertion step by step.
class InsertionWatch {
 public:
  InsertionWatch(const Scene& scene, const State& start) noexcept;

  // After each step. Empty while the insertion goes on; `inserted` once deep enough, or `high_loss`
  // where the joint with an ideal partner loses more than success.loss_dB there; and the failures
  // of the fibre (force_limit, jam, missed, buckled) and of time.
  std::optional<Outcome> after(const StepResult& result) noexcept;
  // The same with the forces of friction there; null where a later step tells the friction's work
  // since.
  std::optional<Outcome> after(const StepResult& result, const TermForces* friction) noexcept;

  const InsertionSummary& summary() const noexcept { return summary_; }

 private:
  const Scene& scene_;
  Pose tip_before_;
  InsertionSummary summary_;
};

}  // namespace ferrule
