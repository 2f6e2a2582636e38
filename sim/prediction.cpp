#include "sim/prediction.hpp"

#include <cmath>

#include "sim/friction_limits.hpp"

namespace ferrule {
namespace {

constexpr double kShortMove = 0.1;    // of the clearance: as far as a prediction reaches
constexpr double kLargestMiss = 0.3;  // of the gradient, that a prediction may leave there
constexpr int kLocated = 8;           // bisections of the way to where a contact begins

// Is friction after a move what it was taken to be, slipping on or stuck?
bool rubs_on(const World& world, const std::array<FrozenFriction, kContactPlaces>& before,
             const FrozenCoefficients& after, const PoseVector& tip,
             const PoseVector& move) noexcept {
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const FrozenFriction& friction = before[at];
    if (!friction.acts) continue;
    const Vector3d now = stretch(world, after, static_cast<int>(at), tip);
    const Vector3d next = now + stretch_by(world, after, static_cast<int>(at), move);
    const double length = now.norm(), length_then = next.norm();
    const bool slipped = friction.stiffness * length > kSlipsOn * friction.limit;
    if (slipped != after.friction[at].slips(next)) return false;
    if (slipped && next.dot(now) < (1 - 0.5 * kTurned * kTurned) * length * length_then)
      return false;
  }
  return true;
}

// A Newton step and what the friction limits change along it; the whole move, if there is one.
// Limit and depth may hold each other in check within far less than either alone would change: to
// first order they change together from where the step begins.
std::optional<PoseVector> predict_rubbing(const World& world, const Energy& here,
                                          const PoseVector& tip, FrozenCoefficients& frozen,
                                          std::optional<NewtonStep>& newton) noexcept {
  const auto first = frozen.friction;
  newton.emplace(world, frozen, here, tip, 1, Pivots::as_they_are, true);
  auto move = FrictionLimits(world, frozen, tip, kSlipsOn).settle(*newton, frozen);
  if (move && rubs_on(world, first, frozen, tip, *move)) return move;
  frozen.friction = first;
  newton.emplace(world, frozen, here, tip);
  if (!newton->convex) return std::nullopt;
  return FrictionLimits(world, frozen, moved_along(world, frozen, tip, newton->move), 1)
      .settle(*newton, frozen);
}

}  // namespace

Prediction predict(const World& world, const State& state, FrozenCoefficients& frozen) noexcept {
  Prediction end;
  end.tip = state.tip;
  if (!state.linearization || state.linearization->at != state.tip) return end;
  const Linearization& bore = *state.linearization;
  Energy here = without_friction(frozen, end.tip, bore.gradient, bore.hessian);
  here.gradient += bore.curvature;
  std::optional<NewtonStep> newton;
  if (frozen.rubs()) {
    const auto move = predict_rubbing(world, here, end.tip, frozen, newton);
    if (!move) return end;
    end.move = *move;
  } else {
    newton.emplace(world, frozen, here, end.tip, 1);
    if (!newton->convex) return end;
    end.move = newton->move;
  }
  const double way = travel_of(world, frozen, end.move);
  if (!(way >= kResolution && way <= kShortMove * world.annulus.clearance())) return end;
  end.hessian = newton->hessian;
  end.slope = std::abs(end.move.dot(newton->model.gradient));
  end.tip = moved_along(world, frozen, state.tip, end.move);
  end.valid = true;
  return end;
}

bool correct(const World& world, const FrozenCoefficients& frozen, const Prediction& end,
             const PoseVector& curvature, Minimum& found) noexcept {
  const Potential& there = found.there;
  if (!(std::abs(end.move.dot(there.gradient)) <= kLargestMiss * end.slope)) return false;
  found.iterations = 1;
  found.curvature = curvature;
  found.curvature += there.gradient;
  if (residual(world, there.gradient) <= kNearForce * there.force_scale)
    final_newton_step(world, frozen, end.hessian.solve(there.gradient), found);
  return true;
}

double stiffness_determinant(const World& world, const State& state) noexcept {
  if (!state.linearization || state.linearization->at != state.tip) return NAN;
  const PoseVector tip(state.tip);
  const FrozenCoefficients frozen = freeze(world, state, state.command, 0);
  const Linearization& bore = *state.linearization;
  const NewtonStep newton(world, frozen, without_friction(frozen, tip, bore.gradient, bore.hessian),
                          tip, 1, Pivots::as_they_are, true);
  return FrictionLimits(world, frozen, tip, kSlipsOn).determinant(newton);
}

double first_touch(const World& world, const State& before, const Prediction& end,
                   const Potential& there) noexcept {
  double first = 1;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactDepth& depth = there.depth[place];
    const ContactState& was = before.contact[place];
    if (was.closed || was.branch != 0 || depth.value == -INFINITY) continue;
    const double way = depth.by_pose(end.tip.t).dot(end.move);
    const auto touches = [&](double part) {
      const double d = depth.value - (1 - part) * way;
      return d > 0 || adhesion_force(world.laws, d, 0).branch != 0;
    };
    if (!touches(first)) continue;
    double low = 0;
    for (int n = 0; n < kLocated; ++n) {
      const double middle = 0.5 * (low + first);
      (touches(middle) ? first : low) = middle;
    }
  }
  return first < 1 ? first : NAN;
}

}  // namespace ferrule
