#include "sim/solver/local_model.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

constexpr double kLeastPivot = 1e-3;  // of the holder's stiffness

// The inverse of a symmetric matrix as it is, and with the magnitudes of its eigenvalues, each of
// at least `least`.
struct Magnitude {
  Matrix2d inverse, positive;

  Magnitude(const Matrix2d& m, double least) noexcept {
    const double mean = 0.5 * (m(0, 0) + m(1, 1)), half = 0.5 * (m(0, 0) - m(1, 1));
    const double spread = std::sqrt(half * half + m(1, 0) * m(1, 0));
    const auto over = [&](double value) {
      return 1 / std::copysign(std::max(std::abs(value), least), value);
    };
    const double high = over(mean + spread), low = over(mean - spread);
    Matrix2d first = 0.5 * kIdentity;  // projector onto the first eigenvector
    if (spread > 0) first = 0.5 / spread * (m - (mean - spread) * kIdentity);
    const Matrix2d second = kIdentity - first;
    inverse = high * first + low * second;
    positive = std::abs(high) * first + std::abs(low) * second;
  }
};

// Do two slips differ in direction by no more than a model is good for?
bool same_direction(const Vector3d& a, const Vector3d& b) noexcept {
  return a.dot(b) >= (1 - 0.5 * kLinearTurn * kLinearTurn) * a.norm() * b.norm();
}

// Whether a contact is taken for what it is after the step; if not, `about` is what it is then.
bool mapping_agrees(const FrozenFriction& friction, Vector3d next, Vector3d& about) noexcept {
  const bool slid = friction.slides(about), slides = friction.slides(next);
  if (!slid && !slides) return true;
  if (slid && slides) {
    if (next.dot(about) <= 0)  // it comes to rest on the way
      next.setZero();
    else if (same_direction(next, about))
      return true;
  }
  about = next;
  return false;
}

}  // namespace

void BlockLdl::factor_magnitudes(const PoseMatrix& h, const PoseMatrix& least) noexcept {
  const Magnitude tt(h.tt, kLeastPivot * least.tt(0, 0));
  over_tt_ = tt.positive;
  et_over_tt_ = h.et * tt.inverse;
  xt_over_tt_ = tt.inverse * h.xt;
  const Magnitude ee(h.ee - et_over_tt_ * h.et.transpose(), kLeastPivot * least.ee(0, 0));
  over_ee_ = ee.positive;
  const Vector2d xe = h.xe - et_over_tt_ * h.xt;
  xe_over_ee_ = ee.inverse * xe;
  const double xx = h.xx - xt_over_tt_.dot(h.xt) - xe_over_ee_.dot(xe);
  over_xx_ = 1 / std::max(std::abs(xx), kLeastPivot * least.xx);
}

NewtonStep::NewtonStep(const World& world, const FrozenCoefficients& frozen, const Energy& smooth,
                       const PoseVector& tip, int rounds, Pivots pivots, bool slides_on) noexcept {
  std::array<Vector3d, kContactPlaces> slip, about;
  const bool friction_acts = frozen.has_friction();
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const FrozenFriction& friction = frozen.friction[at];
    if (!friction.acts) continue;
    about[at] = slip[at] = elastic_slip(world, frozen, static_cast<int>(at), tip);
    const double part = friction.stiffness * slip[at].norm() / friction.limit;
    if ((rounds > 1 || slides_on) && part > kSlidingOn && part <= 1)
      about[at] *= (1 + 1e-12) / part;
  }
  for (int round = 0; round < rounds; ++round) {
    model.gradient = smooth.gradient;
    model.hessian = smooth.hessian;
    for (int place = 0; friction_acts && place < kContactPlaces; ++place) {
      const auto at = static_cast<std::size_t>(place);
      if (frozen.friction[at].acts)
        add_friction_about(model, world, frozen, place, slip[at], about[at]);
    }
    negative = factors.factor(model.hessian);
    convex = negative == 0;
    if (!convex && pivots == Pivots::magnitudes)
      factors.factor_magnitudes(model.hessian, frozen.stiffness);
    move = factors.solve(model.gradient);
    predicted_decrease = -move.dot(model.gradient);
    if (round + 1 == rounds) return;
    bool agrees = true;
    for (int place = 0; friction_acts && place < kContactPlaces; ++place) {
      const auto at = static_cast<std::size_t>(place);
      const FrozenFriction& friction = frozen.friction[at];
      if (!friction.acts) continue;
      const Vector3d next = slip[at] + elastic_slip_by(world, frozen, place, move);
      agrees = mapping_agrees(friction, next, about[at]) && agrees;
    }
    if (agrees) break;
    if (round + 2 == rounds) about = slip;  // they do not: friction as it is here
  }
}

bool friction_agrees(const World& world, const std::array<FrozenFriction, kContactPlaces>& before,
                     const FrozenCoefficients& after, const PoseVector& tip, const PoseVector& move,
                     double slides_at) noexcept {
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const FrozenFriction& friction = before[at];
    if (!friction.acts) continue;
    const Vector3d now = elastic_slip(world, after, static_cast<int>(at), tip);
    const Vector3d next = now + elastic_slip_by(world, after, static_cast<int>(at), move);
    const bool slid = friction.stiffness * now.norm() > slides_at * friction.limit;
    if (slid != after.friction[at].slides(next)) return false;
    if (slid && !same_direction(now, next)) return false;
  }
  return true;
}

}  // namespace ferrule
