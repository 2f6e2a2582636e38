#include "learn/candidates.hpp"

#include <gtest/gtest.h>

#include "insertion/scene_scaling.hpp"
#include "sim/base/data_folder.hpp"

namespace ferrule {
namespace {

// The file is what compare sets beside the learners, at the speed limit of `bench`.
TEST(Candidates, TheControllerTunedByHandShipsAsAFile) {
  const Scene bench = load_scene("bench");
  const double speed = scene_scaling(bench).motion * bench.limits.speed;
  Law tuned = tuned_by_hand(speed);
  const auto file = load_controller(data_folder() + "/controllers/tuned_by_hand.json")(0);
  for (const double force : {0.0, 0.5, 8.0})
    for (const double time : {0.0, 0.05, 2.0}) {
      const Observation o{HandWrench(force, -0.3 * force, 0.7 * force, 0, 0), 1e-3, time};
      EXPECT_TRUE(file->command(o).isApprox(tuned.command(o), 1e-12));
    }
}

}  // namespace
}  // namespace ferrule
