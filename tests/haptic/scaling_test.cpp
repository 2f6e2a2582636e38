#include "haptic/scaling.hpp"

#include "controller/law.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

const Scaling kPaper = Scaling::from_ranges(0.1, 400e-6, 8.46, 10e-6);

TEST(Scaling, OfThePapersDevice) {
  EXPECT_CLOSE(kPaper.motion, 250, 1e-14);
  EXPECT_CLOSE(kPaper.force, 8.46e5, 1e-14);
}

TEST(Scaling, GoesBothWays) {
  Eigen::Matrix<double, 5, 1> tip;
  tip << 1e-6, -2e-6, 3e-6, 1e-3, -2e-3;
  const HandPose hand = kPaper.motion_to_hand(tip);
  EXPECT_CLOSE(hand[1], -0.5e-3, 1e-14);
  EXPECT_EQ(hand[3], 1e-3);
  EXPECT_LT((kPaper.motion_to_tip(hand) - tip).norm(), 1e-15 * tip.norm());
}

// Force times displacement scales by alpha_f alpha_x, for translation and rotation alike.
TEST(Scaling, ScalesWorkTheSameForForcesAndMoments) {
  Eigen::Matrix<double, 5, 1> wrench, move;
  wrench << 1e-6, -2e-6, 3e-6, 4e-10, -5e-10;
  move << 1e-9, 2e-9, -1e-9, 1e-5, 3e-5;
  EXPECT_CLOSE(kPaper.wrench_to_hand(wrench).dot(kPaper.motion_to_hand(move)),
               kPaper.force * kPaper.motion * wrench.dot(move), 1e-14);
}

// An admittance of A m/(s N) in the hand's world is one of A alpha_f/alpha_x at the tip.
TEST(Scaling, ALawLearnedInTheHandsWorldIsTheSameLawAtTheTip) {
  std::array<double, kGains> gains{};
  gains[1] = gains[3] = 1;
  gains[6] = 0.8e-3;
  Law law(LawKind::insertion, {gains.begin(), gains.end()});
  Eigen::Matrix<double, 5, 1> tip_wrench = Eigen::Matrix<double, 5, 1>::Zero();
  tip_wrench[1] = 2e-6;
  const Observation observation = {kPaper.wrench_to_hand(tip_wrench), 0, 1};
  const auto tip_velocity = kPaper.motion_to_tip(law.command(observation));
  EXPECT_CLOSE(tip_velocity[1], 0.8e-3 * 8.46e5 / 250 * 2e-6, 1e-14);
}

}  // namespace
}  // namespace ferrule
