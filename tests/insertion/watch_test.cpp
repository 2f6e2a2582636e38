#include "insertion/watch.hpp"

#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

Outcome push_straight(const Scene& scene, const Pose& tip) {
  StepResult r(at_rest(scene.world, tip));
  InsertionWatch watch(scene, r.state);
  while (true) {
    Pose hand = r.state.command;
    hand[0] -= scene.limits.speed * 1e-3;
    step_on(scene.world, hand, 1e-3, r);
    if (const auto outcome = watch.after(r)) return *outcome;
  }
}

Pose pose(double x, double y, double tilt = 0) {
  Pose p;
  p << x, y, 0, tilt, 0;
  return p;
}

TEST(DrawStart, HasTheMomentsOfTheScene) {
  const Scene scene = testing::paper();
  double y = 0, yy = 0, tilt = 0;
  const int n = 4000;
  for (int k = 0; k < n; ++k) {
    const Pose tip = draw_start(scene, 3, static_cast<std::uint64_t>(k)).tip;
    EXPECT_EQ(tip[0], scene.start.distance);
    y += tip[1];
    yy += tip[1] * tip[1];
    tilt += tip[4] * tip[4];
  }
  EXPECT_CLOSE(y / n, -1.1e-6, 0.02);
  EXPECT_CLOSE(std::sqrt(yy / n - y * y / n / n), 0.15e-6, 0.05);
  EXPECT_CLOSE(std::sqrt(tilt / n), 0.5e-3, 0.05);
}

TEST(InsertionWatch, TellsHowAnInsertionEnds) {
  const Scene scene = testing::paper({"limits.time_s=30"});
  EXPECT_EQ(push_straight(scene, pose(40e-6, 0)), Outcome::inserted);
  EXPECT_EQ(push_straight(scene, pose(120e-6, 80e-6)), Outcome::missed);
  EXPECT_EQ(push_straight(scene, pose(120e-6, 40e-6)), Outcome::force_limit);
  EXPECT_EQ(push_straight(testing::paper({"limits.time_s=2"}), pose(40e-6, 0)), Outcome::timeout);
  // Stiffly held at an angle that two-point contact does not allow.
  const Scene stiff = testing::bare({"holder.tilt_stiffness_N_m_rad=1e-2", "limits.time_s=30",
                                     "success.depth_um=300", "holder.stiffness_N_m=5"});
  EXPECT_EQ(push_straight(stiff, pose(1e-6, 0, 12e-3)), Outcome::jam);
}

TEST(InsertionWatch, AFibreWhoseJointLosesTooMuchIsNotInserted) {
  const auto ends = [](const std::string& most, const std::string& offset) {
    return push_straight(testing::paper({"limits.time_s=30", "success.loss_dB=" + most,
                                         "joint.offset_y_um=" + offset, "joint.offset_z_um=0"}),
                         pose(40e-6, 0));
  };
  // 4.343 (2/5.2)^2 = 0.642 dB, where the fibre is off by half a micrometre at most.
  EXPECT_EQ(ends("0.3", "2"), Outcome::high_loss);
  EXPECT_EQ(ends("1.1", "2"), Outcome::inserted);
  EXPECT_EQ(ends("0.3", "0"), Outcome::inserted);
}

// In the printed wells some steps end where their evaluations do, in the corrected scene none.
TEST(InsertionWatch, CountsTheStepsWithoutAMinimum) {
  const Scene scene = load_scene("bench");
  InsertionWatch watch(scene, draw_start(scene, 1, 1));
  StepResult result =
      step(scene.world, draw_start(scene, 1, 1), draw_start(scene, 1, 1).command, 1e-3);
  for (int n = 0; n < 30; ++n) {
    result.status = n % 10 == 3   ? StepStatus::iteration_limit
                    : n % 10 == 7 ? StepStatus::not_converged
                                  : StepStatus::ok;
    watch.after(result);
  }
  EXPECT_EQ(watch.summary().steps, 30);
  EXPECT_EQ(watch.summary().unfinished, 6);
}

TEST(InsertionWatch, EulerLoadIsThatOfAClampedFreeRod) {
  // Silica, 125 um, 10 mm: E pi r^4/4 pi^2/(4 L^2) = 21 mN.
  const Scene scene = testing::paper({"fibre.young_GPa=72", "fibre.manipulated_length_mm=10"});
  EXPECT_CLOSE(scene.world.holder.euler_load, 21e-3, 0.02);
}

TEST(Outcome, NamesRoundTrip) {
  for (int i = 0; i < kOutcomes; ++i)
    EXPECT_EQ(outcome_from_name(name(static_cast<Outcome>(i))), static_cast<Outcome>(i));
  EXPECT_THROW(outcome_from_name("splendid"), BadInput);
}

}  // namespace
}  // namespace ferrule
