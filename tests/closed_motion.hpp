// The work of a hand that wanders and comes back to where it began, for tests: what dissipates
// never gives any back.
#pragma once

#include <gtest/gtest.h>

#include <cmath>

#include "sim/analysis/hand_work.hpp"
#include "sim/base/random.hpp"
#include "sim/model/state.hpp"
#include "sim/solver/step.hpp"

namespace ferrule::testing {

struct ClosedMotion {
  int inwards, wandering, all;  // steps of 1 ms: so many of them drift in, so many wander
  double drift;                 // [m] a step
  double across, tilts;         // standard deviations a step [m, rad]
};

inline void expect_no_energy_gained(const World& world, const Pose& start,
                                    const ClosedMotion& motion, RandomStream& random) {
  StepResult r(at_rest(world, start));
  const State& state = r.state;
  Pose hand = state.command;
  HandWork work(world, state);
  for (int n = 0; n < motion.all; ++n) {
    if (n < motion.wandering)
      for (int i = 0; i < 5; ++i)
        hand[i] += (i < 3 ? motion.across : motion.tilts) * random.normal() -
                   (i == 0 && n < motion.inwards ? motion.drift : 0);
    else
      hand += (start - hand) / (motion.all - n);
    work.move(state, hand);
    step_on(world, hand, 1e-3, r);
    ASSERT_LE(r.evaluations, SolverParameters{}.max_evaluations);
    ASSERT_TRUE(to_row(state).allFinite());
  }
  EXPECT_FALSE(work.gained(state));
}

}  // namespace ferrule::testing
