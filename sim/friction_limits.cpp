#include "sim/friction_limits.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

constexpr double kMostChange = 0.5;  // of a limit, in one go
constexpr double kFlat = 100;        // more of it: given limits hardly hold the pose
constexpr double kSingular = 0.05;   // less of a determinant: limit and depth drive each other on

}  // namespace

FrictionLimits::Place FrictionLimits::place(const World& world, const FrozenCoefficients& frozen,
                                            const PoseVector& tip, int at, const FrictionLimit& is,
                                            const PoseVector& depth_slope,
                                            double slips_at) noexcept {
  Place place;
  if (!(is.limit > 0)) return place;
  const FrozenFriction& friction = frozen.friction[at];
  const Vector3d stretched = stretch(world, frozen, at, tip);
  const double length = stretched.norm();
  place.slips = friction.stiffness * length > slips_at * friction.limit ||
                is.stiffness * length > slips_at * is.limit;
  if (!place.slips) return place;
  place.limit = friction.limit;
  place.stiffness = is.stiffness;
  place.miss = is.limit - friction.limit;
  place.per_depth = is.per_depth;
  place.depth_slope = depth_slope;
  place.pull = pull_of_friction(world, frozen, at, stretched);
  return place;
}

FrictionLimits::FrictionLimits(const World& world, const FrozenCoefficients& frozen,
                               const PoseVector& tip, const Potential& there) noexcept {
  const auto limits = friction_limits(world, frozen, there);
  for (int at = 0; at < kContactPlaces; ++at)
    if (frozen.friction[at].acts)
      place_[at] = place(world, frozen, tip, at, limits[at], there.depth[at].by_pose(tip.t), 1);
}

FrictionLimits::FrictionLimits(const World& world, const FrozenCoefficients& frozen,
                               const PoseVector& tip, double slips_at) noexcept {
  for (int at = 0; at < kContactPlaces; ++at)
    if (const FrozenFriction& friction = frozen.friction[at]; friction.acts)
      place_[at] = place(world, frozen, tip, at, friction, friction.depth_slope, slips_at);
}

double FrictionLimits::largest_miss() const noexcept {
  double largest = 0;
  for (const Place& place : place_)
    if (place.slips) largest = std::max(largest, std::abs(place.miss) / place.limit);
  return largest;
}

// The Hessian at given limits, and how these give way.
Matrix5 FrictionLimits::together(const NewtonStep& newton) const noexcept {
  Matrix5 sum = newton.model.hessian.full();
  for (const Place& place : place_)
    if (place.slips)
      sum += place.per_depth * place.pull.full() * place.depth_slope.full().transpose();
  return sum;
}

double FrictionLimits::determinant(const NewtonStep& newton) const noexcept {
  return Eigen::PartialPivLU<Matrix5>(together(newton)).determinant();
}

// Where the Hessian at given limits is nearly singular or falls: both systems as one.
std::optional<PoseVector> FrictionLimits::settle_together(
    const NewtonStep& newton, FrozenCoefficients& frozen) const noexcept {
  Pose force = -newton.model.gradient.full();
  for (const Place& place : place_)
    if (place.slips) force -= place.miss * place.pull.full();
  const Eigen::PartialPivLU<Matrix5> solver(together(newton));
  if (!(solver.determinant() > 0)) return std::nullopt;
  const PoseVector move{Pose(solver.solve(force))};
  std::array<double, kContactPlaces> by{};
  for (int j = 0; j < kContactPlaces; ++j) {
    const Place& place = place_[j];
    if (!place.slips) continue;
    by[j] = place.miss + place.per_depth * place.depth_slope.dot(move);
    if (!(std::abs(by[j]) <= kMostChange * place.limit)) return std::nullopt;
  }
  for (int j = 0; j < kContactPlaces; ++j) {
    if (!place_[j].slips) continue;
    frozen.friction[j].limit += by[j];
    frozen.friction[j].stiffness = place_[j].stiffness;
  }
  return move;
}

std::optional<PoseVector> FrictionLimits::settle(const NewtonStep& newton,
                                                 FrozenCoefficients& frozen) const noexcept {
  if (newton.falling > 0) return settle_together(newton, frozen);
  // change = miss + d limit/d depth . depth by pose . move,
  // move = held + sum of answer_j change_j
  const PoseVector& held = newton.move;
  std::array<PoseVector, kContactPlaces> answer;
  Matrix2d system = Matrix2d::Identity();
  Vector2d miss = Vector2d::Zero();
  for (int j = 0; j < kContactPlaces; ++j) {
    if (!place_[j].slips) continue;
    answer[j] = newton.hessian.solve(place_[j].pull);
    miss[j] = place_[j].miss + place_[j].per_depth * place_[j].depth_slope.dot(held);
    for (int i = 0; i < kContactPlaces; ++i)
      if (place_[i].slips)
        system(i, j) -= place_[i].per_depth * place_[i].depth_slope.dot(answer[j]);
  }
  const double determinant = system(0, 0) * system(1, 1) - system(0, 1) * system(1, 0);
  if (determinant > kFlat) return settle_together(newton, frozen);
  Vector2d change = miss;
  if (determinant > kSingular)
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
