#include "sim/solver/friction_coupling.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

constexpr double kMaxChange = 0.5;  // of a limit, in one step
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

CoupledModel::CoupledModel(const NewtonStep& newton, const FrictionCoupling& coupling) noexcept
    : newton_(newton), place_(coupling.place_) {
  for (int j = 0; j < kContactPlaces; ++j) {
    if (!place_[j].slides) continue;
    response_[j] = newton.factors.solve(place_[j].direction);
    for (int i = 0; i < kContactPlaces; ++i) schur_(i, j) -= limit_by(i, response_[j]);
  }
}

// What the limit of a place changes by with a move [N].
double CoupledModel::limit_by(int place, const PoseVector& move) const noexcept {
  const FrictionCoupling::Place& at = place_[place];
  return at.slides ? at.per_depth * at.depth_slope.dot(move) : 0;
}

bool CoupledModel::stable() const noexcept {
  return newton_.convex && schur_(0, 0) > 0 && schur_.determinant() > 0;
}

double CoupledModel::determinant() const noexcept {
  return newton_.factors.determinant() * schur_.determinant();
}

PoseVector CoupledModel::solve(const PoseVector& gradient) const noexcept {
  PoseVector move = newton_.factors.solve(gradient);
  const Vector2d change = solve_schur({limit_by(kEnd, move), limit_by(kSide, move)});
  for (int j = 0; j < kContactPlaces; ++j)
    if (place_[j].slides) move += change[j] * response_[j];
  return move;
}

Vector2d CoupledModel::solve_schur(const Vector2d& v) const noexcept {
  return Vector2d(schur_(1, 1) * v[0] - schur_(0, 1) * v[1],
                  schur_(0, 0) * v[1] - schur_(1, 0) * v[0]) /
         schur_.determinant();
}

std::optional<PoseVector> CoupledModel::step(FrozenCoefficients& frozen) const noexcept {
  PoseVector move = newton_.move;
  Vector2d change = Vector2d::Zero();
  for (int j = 0; j < kContactPlaces; ++j)
    if (place_[j].slides) change[j] = place_[j].error + limit_by(j, move);
  // Where given limits do not hold the pose, only limits that follow it do.
  const bool must_follow = newton_.negative > 0;
  if (must_follow && !(determinant() > 0)) return std::nullopt;
  if (must_follow || schur_.determinant() > kSingular) change = solve_schur(change);
  for (int j = 0; j < kContactPlaces; ++j)
    if (must_follow && place_[j].slides && !(std::abs(change[j]) <= kMaxChange * place_[j].limit))
      return std::nullopt;
  for (int j = 0; j < kContactPlaces; ++j) {
    const FrictionCoupling::Place& place = place_[j];
    if (!place.slides) continue;
    const double most = kMaxChange * place.limit, by = std::clamp(change[j], -most, most);
    frozen.friction[j].limit += by;
    frozen.friction[j].stiffness = place.stiffness;
    move += by * response_[j];
  }
  return move;
}

}  // namespace ferrule
