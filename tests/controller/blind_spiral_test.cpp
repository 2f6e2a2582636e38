#include "controller/blind_spiral.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

constexpr double kSpiralSpeed = 1, kSpiralForce = 1, kSpiralPitch = 0.1, kSpiralPeriod = 1e-3;

// A face at x = -1 as stiff as 1000 N/m, but for a hole at `hole`.
class StiffFace {
 public:
  explicit StiffFace(const Eigen::Vector2d& hole) : hole_(hole) {}
  double force(const HandPose& q) const {
    const bool in_hole = (q.segment<2>(1) - hole_).norm() < 0.5 * kSpiralPitch;
    return in_hole ? 0 : 1000 * std::max(0.0, -1 - q[0]);
  }

 private:
  Eigen::Vector2d hole_;
};

// Where it touched, until it is deeper than 2 or `ticks` are over.
std::vector<Eigen::Vector2d> touched_places(const StiffFace& face, int ticks, HandPose& q) {
  BlindSpiral spiral(kSpiralSpeed, kSpiralForce, kSpiralPitch);
  std::vector<Eigen::Vector2d> places;
  bool touching = false;
  for (int k = 0; k < ticks && q[0] > -2; ++k) {
    Observation o{};
    o.wrench[0] = face.force(q);
    o.displacement = q;
    const bool touches = o.wrench[0] > kSpiralForce;
    if (touches && !touching) places.push_back(q.segment<2>(1));
    touching = touches;
    q += kSpiralPeriod * spiral.command(o);
  }
  return places;
}

TEST(BlindSpiral, TouchesAlongArchimedesSpiralAPitchApart) {
  HandPose q = HandPose::Zero();
  const auto places = touched_places(StiffFace({100, 0}), 300000, q);
  ASSERT_GT(places.size(), 200U);
  double turned = 0, before = 0;
  for (std::size_t k = 1; k < places.size(); ++k) {
    // Turns as far as it must for its radius, from one place to the next by less than a half turn.
    const double angle = std::atan2(places[k].y(), places[k].x());
    turned += std::remainder(angle - before, 2 * std::numbers::pi);
    before = angle;
    if (k > 4) {
      EXPECT_NEAR((places[k] - places[k - 1]).norm(), kSpiralPitch, 0.1 * kSpiralPitch) << k;
    }
    EXPECT_NEAR(std::remainder(places[k].norm() - kSpiralPitch * turned / (2 * std::numbers::pi),
                               kSpiralPitch),
                0, 0.1 * kSpiralPitch)
        << k;
  }
}

TEST(BlindSpiral, GoesInWhereNothingHoldsIt) {
  HandPose q = HandPose::Zero();
  const Eigen::Vector2d hole(0.21, -0.33);
  touched_places(StiffFace(hole), 300000, q);
  EXPECT_LE(q[0], -2);
  EXPECT_LT((q.segment<2>(1) - hole).norm(), 0.5 * kSpiralPitch);
}

TEST(BlindSpiral, InsertsNearbyAndRunsOutOfTimeFurtherAway) {
  const auto inserted = [](double scatter_um) {
    const Scene scene = load_scene("bench", {"ferrule.lead_in=null", "fibre.cleave_deg=0",
                                             "start.lateral_sd_um=" + std::to_string(scatter_um)});
    const Scaling scaling = scene_scaling(scene);
    int count = 0;
    for (std::uint64_t trial = 0; trial < 12; ++trial) {
      BlindSpiral spiral(scaling.motion * scene.limits.speed,
                         scaling.force * scene.limits.force / 12,
                         1.4 * scaling.motion * scene.world.annulus.clearance());
      count += run_trial(scene, spiral, 3, trial).outcome == Outcome::inserted;
    }
    return count;
  };
  EXPECT_GE(inserted(1), 10);
  EXPECT_LE(inserted(15), 4);
}

}  // namespace
}  // namespace ferrule
