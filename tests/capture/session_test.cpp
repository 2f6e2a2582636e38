#include "capture/session.hpp"

#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// A hand whose velocity is a known function of the force it felt last.
class KnownHand : public Device {
 public:
  explicit KnownHand(const HandPose& start) : pose_(start) {}
  HandSample read(double t) override {
    pose_ += velocity_ * (t - time_);
    time_ = t;
    return {pose_, t > 5};
  }
  void render(const HandWrench& wrench) override { velocity_ << -2e-3, 1e-3 * wrench.tail<4>(); }

 private:
  HandPose pose_;
  HandTwist velocity_ = HandTwist::Zero();
  double time_ = 0;
};

TEST(Session, ARowPairsAForceWithTheVelocityThatAnswersIt) {
  const Scene scene = testing::paper();
  const Scaling scaling = scene_scaling(scene);
  const State start = draw_start(scene, 1, 1);
  KnownHand hand(scaling.motion_to_hand(start.command));
  std::vector<RowVector> rows;
  run_episode(
      scene, start, hand, {}, 1e-3, [&](const RowVector& row) { rows.push_back(row); },
      [] { return false; });
  ASSERT_GT(rows.size(), 4000u);
  for (std::size_t n = 0; n < rows.size(); ++n) {
    EXPECT_CLOSE(rows[n][kTime.begin], static_cast<double>(n) * 1e-3, 1e-14);
    const HandWrench felt = scaling.wrench_to_hand(rows[n].segment<5>(kHolder.begin).transpose());
    EXPECT_LT(std::abs(rows[n][kCommand.begin + 1] - 1e-3 * felt[1]), 1e-10 * 2e-3);
    if (n == 0) continue;
    EXPECT_EQ(rows[n].segment<5>(kHandVelocity.begin), rows[n - 1].segment<5>(kCommand.begin));
    const Eigen::Matrix<double, 1, 5> moved =
        rows[n].segment<5>(kHandPose.begin) - rows[n - 1].segment<5>(kHandPose.begin);
    EXPECT_LT((moved - 1e-3 * rows[n - 1].segment<5>(kCommand.begin)).norm(), 1e-15);
  }
}

TEST(Session, AHandThatIsNotFiniteEndsTheEpisode) {
  class Broken : public Device {
   public:
    HandSample read(double t) override {
      HandPose pose = HandPose::Zero();
      pose[0] = t > 0.5 ? NAN : 0.01;
      return {pose, false};
    }
    void render(const HandWrench&) override {}
  } broken;
  const Scene scene = testing::paper();
  std::size_t rows = 0;
  const EpisodeEnd end = run_episode(
      scene, draw_start(scene, 1, 1), broken, {}, 1e-3, [&](const RowVector&) { ++rows; },
      [] { return false; });
  EXPECT_EQ(end.outcome, Outcome::invalid_output);
  EXPECT_GT(rows, 490u);
}

}  // namespace
}  // namespace ferrule
