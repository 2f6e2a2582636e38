#include "insertion/scene_scaling.hpp"

#include <gtest/gtest.h>

#include "insertion/sensed_wrench.hpp"
#include "insertion/simulated_operator.hpp"
#include "learn/demonstrations.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// Straight in, from a start on the axis.
Scene straight(const std::vector<std::string>& settings = {}) {
  std::vector<std::string> all = {"start.lateral_sd_um=0", "start.tilt_sd_mrad=0",
                                  "laws.gravity=null", "limits.force_uN=1e6",
                                  "start.lateral_mean_um=[0,0]"};
  all.insert(all.end(), settings.begin(), settings.end());
  return testing::bare(all);
}

// Notes the depths that it observes.
class Noting : public ConstantVelocity {
 public:
  using ConstantVelocity::ConstantVelocity;
  HandTwist command(const Observation& o) noexcept override {
    depths.push_back(o.depth);
    return ConstantVelocity::command(o);
  }
  std::vector<double> depths;
};

TEST(RegisteredEntrance, IsDrawnPerTrialAndStatedInWhatIsRecorded) {
  const Scene scene = straight({"sensor.entrance_sd_um=4"});
  double square = 0;
  constexpr int kTrials = 4000;
  for (std::uint64_t k = 0; k < kTrials; ++k) {
    const auto drawn = draw_scene(scene, 3, k);
    const double error = drawn->sensor.entrance_error;
    square += error * error / kTrials;
    EXPECT_EQ(error, 1e-6 * drawn->document()["sensor"]["entrance_error_um"].get<double>());
    if (k > 20) continue;
    EXPECT_EQ(undrawn(drawn->document()), scene.document());
    const Scene again = parse_scene(drawn->document(), "drawn");
    EXPECT_EQ(draw_scene(again, 9, k).get(), &again);
    EXPECT_EQ(again.sensor.entrance_error, error);
  }
  EXPECT_CLOSE(std::sqrt(square), 4e-6, 4 / std::sqrt(2.0 * kTrials));
}

// The hand of a controller ends where it takes the depth to be reached; inserted is what is deep
// enough in truth.
TEST(RegisteredEntrance, IsWhatEndsATrialOfTheControllersOwnAndNotWhatCountsAsInserted) {
  for (const double error : {-20.0, 0.0, 4.0, 20.0}) {
    const Scene scene = straight({"sensor.entrance_error_um=" + std::to_string(error)});
    const double goal = 1.1 * scene.success.depth;
    const State start = draw_start(scene, 1, 1);
    const double speed = scene_scaling(scene).motion * scene.limits.speed;
    ConstantVelocity controller(speed);
    ControllerHand hand = recorded_hand(testing::setup(scene, start), controller);
    const InsertionEnd end =
        run_insertion(testing::setup(scene, start), hand, {.past_success = true});
    const double depth = end.summary.depth, one_step = 1.01e-3 * scene.limits.speed;
    EXPECT_LE(std::abs(depth - (goal - 1e-6 * error)), one_step) << error;
    EXPECT_EQ(end.outcome == Outcome::inserted, depth >= scene.success.depth) << error;
    EXPECT_EQ(end.outcome == Outcome::inserted, error < 0.1 * 1e6 * scene.success.depth) << error;
  }
}

TEST(RegisteredEntrance, IsWhatAnOperatorGoesBy) {
  const Scene truth = straight(), scene = straight({"sensor.entrance_error_um=-7"});
  const State start = draw_start(truth, 1, 1);
  EXPECT_CLOSE(trainee_task(testing::setup(scene, start)).distance -
                   trainee_task(testing::setup(truth, start)).distance,
               scene_scaling(scene).motion * 7e-6, 1e-9);
  EXPECT_CLOSE(scene_tare(scene).free_beyond - scene_tare(truth).free_beyond, -7e-6, 1e-6);
}

TEST(RegisteredEntrance, IsLearnedFromAsItWasObserved) {
  const Scene scene = straight({"sensor.entrance_error_um=5"});
  const State start = draw_start(scene, 1, 1);
  Noting controller(scene_scaling(scene).motion * scene.limits.speed);
  ControllerHand hand = recorded_hand(testing::setup(scene, start), controller);
  Episode episode;
  episode.info.scene = scene.document().dump();
  std::vector<RowVector> rows;
  run_insertion(testing::setup(scene, start), hand, {.past_success = true}, [&](const Tick& tick) {
    rows.push_back(make_row(tick));
    return true;
  });
  episode.rows.resize(static_cast<Eigen::Index>(rows.size()), Eigen::NoChange);
  for (std::size_t n = 0; n < rows.size(); ++n)
    episode.rows.row(static_cast<Eigen::Index>(n)) = rows[n];
  const Demonstration d = demonstration(episode, scene, "test");
  ASSERT_EQ(d.observations.size(), (controller.depths.size() + 9) / 10);
  for (std::size_t n = 0; n < d.observations.size(); ++n)
    EXPECT_EQ(d.observations[n].depth, controller.depths[10 * n]) << n;
  EXPECT_GT(controller.depths.back(), 0);
}

}  // namespace
}  // namespace ferrule
