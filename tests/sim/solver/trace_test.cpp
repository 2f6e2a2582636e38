#include "sim/solver/trace.hpp"

#include <gtest/gtest.h>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

TEST(StepTrace, SaysWhatAStepCountsAndChangesNothing) {
  long solved = 0, extrapolated = 0, free = 0, rejected = 0;
  for (const char* name : {"bench", "paper", "epoxy"}) {
    const Scene scene = load_scene(name);
    const State start = draw_start(scene, 3, 1);
    StepResult traced(start), plain(start);
    StepTrace trace;
    for (const Pose& hand : commands(scene, start, Motion::press, 1e-3, 3, 1)) {
      trace.clear();
      step_on(scene.world, hand, 1e-3, traced, &trace);
      step_on(scene.world, hand, 1e-3, plain);
      ASSERT_EQ(to_row(traced.state), to_row(plain.state));
      int evaluations = 0, accepted = 0, given_up = 0;
      double part = 0;
      for (const TraceEntry& entry : trace.entries()) {
        const bool ends =
            entry.stage == SolverStage::accepted || entry.stage == SolverStage::rejected;
        if (ends) evaluations += entry.evaluations;
        accepted += entry.stage == SolverStage::accepted;
        given_up += entry.stage == SolverStage::rejected;
        extrapolated += entry.stage == SolverStage::extrapolation && trace.entries().size() == 1;
        free += entry.stage == SolverStage::free_flight;
        if (entry.stage == SolverStage::accepted) {
          EXPECT_GT(entry.part, part);
          part = entry.part;
        }
      }
      ASSERT_FALSE(trace.entries().empty());
      ASSERT_EQ(evaluations, traced.evaluations);
      ASSERT_EQ(given_up, traced.rejected);
      if (traced.evaluations == 0) continue;
      ++solved;
      rejected += given_up;
      ASSERT_EQ(accepted, traced.substeps);
      EXPECT_EQ(part, 1);
    }
  }
  EXPECT_GT(solved, 1000);
  EXPECT_GT(extrapolated, 1000);
  EXPECT_GT(free, 100);
  EXPECT_GT(rejected, 3);
}

}  // namespace
}  // namespace ferrule
