// A hand that ends where it began, followed step by step.
#pragma once

#include <gtest/gtest.h>

#include <vector>

#include "sim/analysis/hand_work.hpp"
#include "sim/solver/step.hpp"

namespace ferrule::testing {

// The work of a step is bounded, nothing is ever not finite, and no energy is gained. Adds the steps
// that ended without a minimum to `unfinished`.
inline void follow(const World& world, const State& start, const std::vector<Pose>& hand,
                   double period, long& unfinished) {
  StepResult now(start);
  HandWork work(world, start);
  for (const Pose& to : hand) {
    work.move(now.state, to);
    step_on(world, to, period, now);
    ASSERT_LE(now.evaluations, SolverParameters{}.max_evaluations);
    ASSERT_TRUE(to_row(now.state).allFinite() && now.holder.allFinite());
    ASSERT_EQ(now.state.command, to);
    unfinished += now.status != StepStatus::ok;
  }
  EXPECT_FALSE(work.gained(now.state));
}

}  // namespace ferrule::testing
