#include "sim/friction_limits.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

constexpr double kNudge = 1e-12;     // of a depth, for its derivative [m]
constexpr double kMostChange = 0.5;  // of a limit, in one go
constexpr double kSingular = 0.05;   // less of a determinant: limit and depth drive each other on

}  // namespace

FrictionLimits::FrictionLimits(const World& world, const FrozenCoefficients& frozen,
                               const PoseVector& tip,
                               const std::array<ContactDepth, kContactPlaces>& depth) noexcept {
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const FrozenFriction& friction = frozen.friction[at];
    const double d = depth[at].value;
    if (!friction.acts || d == -INFINITY) continue;
    const Vector3d stretched = stretch(world, frozen, static_cast<int>(at), tip);
    const FrictionLimit is = friction_limit(world, friction, d, frozen.branch[at]);
    Place& place = place_[at];
    place.slips =
        is.limit > 0 && (friction.slips(stretched) || is.stiffness * stretched.norm() > is.limit);
    if (!place.slips) continue;
    place.limit = friction.limit;
    place.stiffness = is.stiffness;
    place.miss = is.limit - friction.limit;
    place.per_depth =
        (friction_limit(world, friction, d + kNudge, frozen.branch[at]).limit - is.limit) / kNudge;
    place.depth_slope = depth[at].by_pose(tip.t);
    place.pull = pull_of_friction(world, frozen, static_cast<int>(at), stretched);
  }
}

double FrictionLimits::largest_miss() const noexcept {
  double largest = 0;
  for (const Place& place : place_)
    if (place.slips) largest = std::max(largest, std::abs(place.miss) / place.limit);
  return largest;
}

std::optional<PoseVector> FrictionLimits::settle(const Eliminated& hessian, int falling,
                                                 const PoseVector& held,
                                                 FrozenCoefficients& frozen) const noexcept {
  // change = miss + d limit/d depth . depth by pose . move,   move = held + sum of answer_j change_j
  std::array<PoseVector, kContactPlaces> answer;
  Matrix2d system = Matrix2d::Identity();
  Vector2d miss = Vector2d::Zero();
  for (int j = 0; j < kContactPlaces; ++j) {
    if (!place_[j].slips) continue;
    answer[j] = hessian.solve(place_[j].pull);
    miss[j] = place_[j].miss + place_[j].per_depth * place_[j].depth_slope.dot(held);
    for (int i = 0; i < kContactPlaces; ++i)
      if (place_[i].slips)
        system(i, j) -= place_[i].per_depth * place_[i].depth_slope.dot(answer[j]);
  }
  const double determinant = system(0, 0) * system(1, 1) - system(0, 1) * system(1, 0);
  const double together = falling % 2 ? -determinant : determinant;
  Vector2d change = miss;
  if (falling > 0 && !(together > kSingular)) return std::nullopt;
  if (together > kSingular)
    change = Vector2d(system(1, 1) * miss[0] - system(0, 1) * miss[1],
                      system(0, 0) * miss[1] - system(1, 0) * miss[0]) /
             determinant;
  PoseVector move = held;
  for (int j = 0; j < kContactPlaces; ++j) {
    const Place& place = place_[j];
    if (!place.slips) continue;
    const double by = std::clamp(change[j], -kMostChange * place.limit, kMostChange * place.limit);
    frozen.friction[j].limit += by;
    frozen.friction[j].stiffness = place.stiffness;
    move += by * answer[j];
  }
  return move;
}

}  // namespace ferrule
