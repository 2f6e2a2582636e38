#include "sim/solver/friction_coupling.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

constexpr double kMaxChange = 0.5;  // of a limit, in one step
constexpr double kFlat = 100;       // a determinant above it: given limits hardly hold the pose
constexpr double kSingular = 0.05;  // below it: limit and depth drive each other on

}  // namespace

FrictionCoupling::Place FrictionCoupling::place(
    const World& world, const FrozenCoefficients& frozen, const PoseVector& tip, int at,
    const FrictionLimit& now, const PoseVector& depth_slope, double slides_at) noexcept {
  Place place;
  if (!(now.limit > 0)) return place;
  const FrozenFriction& friction = frozen.friction[at];
  const Vector3d slip = elastic_slip(world, frozen, at, tip);
  const double length = slip.norm();
  place.slides = friction.stiffness * length > slides_at * friction.limit ||
                 now.stiffness * length > slides_at * now.limit;
  if (!place.slides) return place;
  place.limit = friction.limit;
  place.stiffness = now.stiffness;
  place.error = now.limit - friction.limit;
  place.per_depth = now.per_depth;
  place.depth_slope = depth_slope;
  place.direction = friction_direction(world, frozen, at, slip);
  return place;
}

FrictionCoupling::FrictionCoupling(const World& world, const FrozenCoefficients& frozen,
                                   const PoseVector& tip, const Potential& potential) noexcept {
  const auto limits = friction_limits(world, frozen, potential);
  for (int at = 0; at < kContactPlaces; ++at)
    if (frozen.friction[at].acts)
      place_[at] = place(world, frozen, tip, at, limits[at], potential.depth[at].by_pose(tip.t), 1);
}

FrictionCoupling::FrictionCoupling(const World& world, const FrozenCoefficients& frozen,
                                   const PoseVector& tip, double slides_at) noexcept {
  for (int at = 0; at < kContactPlaces; ++at)
    if (const FrozenFriction& friction = frozen.friction[at]; friction.acts)
      place_[at] = place(world, frozen, tip, at, friction, friction.depth_slope, slides_at);
}

double FrictionCoupling::largest_error() const noexcept {
  double largest = 0;
  for (const Place& place : place_)
    if (place.slides) largest = std::max(largest, std::abs(place.error) / place.limit);
  return largest;
}

// The Hessian at given limits, and how these change with the pose.
Matrix5 FrictionCoupling::jacobian(const NewtonStep& newton) const noexcept {
  Matrix5 sum = newton.model.hessian.full();
  for (const Place& place : place_)
    if (place.slides)
      sum += place.per_depth * place.direction.full() * place.depth_slope.full().transpose();
  return sum;
}

double FrictionCoupling::determinant(const NewtonStep& newton) const noexcept {
  return Eigen::PartialPivLU<Matrix5>(jacobian(newton)).determinant();
}

// Where the Hessian at given limits is nearly singular or indefinite: both systems as one.
std::optional<PoseVector> FrictionCoupling::monolithic_step(
    const NewtonStep& newton, FrozenCoefficients& frozen) const noexcept {
  Pose force = -newton.model.gradient.full();
  for (const Place& place : place_)
    if (place.slides) force -= place.error * place.direction.full();
  const Eigen::PartialPivLU<Matrix5> solver(jacobian(newton));
  if (!(solver.determinant() > 0)) return std::nullopt;
  const PoseVector move{Pose(solver.solve(force))};
  std::array<double, kContactPlaces> by{};
  for (int j = 0; j < kContactPlaces; ++j) {
    const Place& place = place_[j];
    if (!place.slides) continue;
    by[j] = place.error + place.per_depth * place.depth_slope.dot(move);
    if (!(std::abs(by[j]) <= kMaxChange * place.limit)) return std::nullopt;
  }
  for (int j = 0; j < kContactPlaces; ++j) {
    if (!place_[j].slides) continue;
    frozen.friction[j].limit += by[j];
    frozen.friction[j].stiffness = place_[j].stiffness;
  }
  return move;
}

std::optional<PoseVector> FrictionCoupling::newton_step(const NewtonStep& newton,
                                                        FrozenCoefficients& frozen) const noexcept {
  if (newton.negative > 0) return monolithic_step(newton, frozen);
  // change = error + d limit/d depth . depth by pose . move,
  // move = given + sum of response_j change_j
  const PoseVector& given = newton.move;
  std::array<PoseVector, kContactPlaces> response;
  Matrix2d system = Matrix2d::Identity();
  Vector2d error = Vector2d::Zero();
  for (int j = 0; j < kContactPlaces; ++j) {
    if (!place_[j].slides) continue;
    response[j] = newton.factors.solve(place_[j].direction);
    error[j] = place_[j].error + place_[j].per_depth * place_[j].depth_slope.dot(given);
    for (int i = 0; i < kContactPlaces; ++i)
      if (place_[i].slides)
        system(i, j) -= place_[i].per_depth * place_[i].depth_slope.dot(response[j]);
  }
  const double determinant = system(0, 0) * system(1, 1) - system(0, 1) * system(1, 0);
  if (determinant > kFlat) return monolithic_step(newton, frozen);
  Vector2d change = error;
  if (determinant > kSingular)
    change = Vector2d(system(1, 1) * error[0] - system(0, 1) * error[1],
                      system(0, 0) * error[1] - system(1, 0) * error[0]) /
             determinant;
  PoseVector move = given;
  for (int j = 0; j < kContactPlaces; ++j) {
    const Place& place = place_[j];
    if (!place.slides) continue;
    const double by = std::clamp(change[j], -kMaxChange * place.limit, kMaxChange * place.limit);
    frozen.friction[j].limit += by;
    frozen.friction[j].stiffness = place.stiffness;
    move += by * response[j];
  }
  return move;
}

}  // namespace ferrule
