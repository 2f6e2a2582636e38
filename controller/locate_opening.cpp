#include "controller/locate_opening.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/NonLinearOptimization>

#include "sim/geometry/face_support.hpp"

namespace ferrule {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// First guesses of the axis, about the last touch.
constexpr int kDirections = 8;
constexpr std::array kDistances = {0.05, 0.3, 1.0, 1.7};  // of r
constexpr int kEvaluations = 40;                          // from each
constexpr int kNumbers = 6, kPriors = 5;

FaceSupport::Rest rest(const Discs& discs, const Vector2d& slope, const Vector2d& e) noexcept {
  const double inside = (1 + 1e-6) * (discs.opening - discs.fibre), off = e.norm();
  Vector2d supported = e;
  if (off < inside) supported = off > 0 ? Vector2d(inside / off * e) : Vector2d(inside, 0);
  return FaceSupport(discs.fibre, discs.opening, supported).rest(slope);
}

// Of another clearance, the nominal one times exp(log_ratio).
Discs with_clearance(const Discs& discs, double log_ratio) noexcept {
  return {discs.fibre, discs.fibre + std::exp(log_ratio) * (discs.opening - discs.fibre)};
}

// What is squared in the sum, of (x_f, a, s, log c/c_0).
class Residuals {
 public:
  Residuals(std::span<const Touch> touches, const Discs& discs, const TouchErrors& errors)
      : touches_(touches), discs_(discs), errors_(errors) {}

  int values() const { return static_cast<int>(touches_.size()) + kPriors; }

  int operator()(const VectorXd& p, VectorXd& residual) const {
    Eigen::Index k = 0;
    for (const Touch& touch : touches_)
      residual[k++] = (touch.x - p[0] - rest_at(p, touch).ahead) / errors_.height;
    residual.segment<2>(k) = p.segment<2>(1) / errors_.far;
    residual.segment<2>(k + 2) = p.segment<2>(3) / errors_.slope;
    residual[k + 4] = p[5] / errors_.clearance;
    return 0;
  }

  int df(const VectorXd& p, MatrixXd& jacobian) const {
    jacobian.setZero();
    Eigen::Index k = 0;
    const Discs discs = with_clearance(discs_, p[5]);
    for (const Touch& touch : touches_) {
      const FaceSupport::Rest rest = rest_at(p, touch);
      // A wider opening is one that lies further from the point on its edge.
      const Vector2d from_axis = rest.point + touch.across - p.segment<2>(1);
      const double by_clearance = rest.by_e.dot(from_axis) / discs.opening;
      jacobian.row(k++) << -1, rest.by_e.transpose(), -rest.point.transpose(),
          by_clearance * (discs.opening - discs.fibre);
    }
    jacobian.topRows(k) /= errors_.height;
    jacobian.block<2, 2>(k, 1).diagonal().setConstant(1 / errors_.far);
    jacobian.block<2, 2>(k + 2, 3).diagonal().setConstant(1 / errors_.slope);
    jacobian(k + 4, 5) = 1 / errors_.clearance;
    return 0;
  }

 private:
  FaceSupport::Rest rest_at(const VectorXd& p, const Touch& touch) const noexcept {
    return rest(with_clearance(discs_, p[5]), p.segment<2>(3) + touch.tilt,
                touch.across - p.segment<2>(1));
  }

  std::span<const Touch> touches_;
  const Discs& discs_;
  const TouchErrors& errors_;
};

// With that axis, no slope, and the face where the touches on average have it.
VectorXd first_guess(std::span<const Touch> touches, const Discs& discs, const Vector2d& axis) {
  VectorXd p = VectorXd::Zero(kNumbers);
  p.segment<2>(1) = axis;
  for (const Touch& touch : touches)
    p[0] += touch.x - rest_height(discs, touch.tilt, touch.across - axis);
  p[0] /= static_cast<double>(touches.size());
  return p;
}

}  // namespace

double rest_height(const Discs& discs, const Vector2d& slope, const Vector2d& e) noexcept {
  return rest(discs, slope, e).ahead;
}

Opening locate_opening(std::span<const Touch> touches, const Discs& discs,
                       const TouchErrors& errors) {
  Residuals residuals(touches, discs, errors);
  VectorXd residual(residuals.values());
  Opening opening;
  double least = std::numeric_limits<double>::infinity();
  for (const double distance : kDistances)
    for (int direction = 0; direction < kDirections; ++direction) {
      const double angle = 2 * std::numbers::pi * direction / kDirections;
      const Vector2d aside = distance * discs.fibre * Vector2d(std::cos(angle), std::sin(angle));
      VectorXd p = first_guess(touches, discs, touches.back().across + aside);
      Eigen::LevenbergMarquardt<Residuals> solver(residuals);
      solver.parameters.maxfev = kEvaluations;
      solver.minimize(p);
      residuals(p, residual);
      if (!(residual.squaredNorm() < least)) continue;
      least = residual.squaredNorm();
      const double squares = residual.head(residual.size() - kPriors).squaredNorm();
      opening = {p.segment<2>(1), p.segment<2>(3), p[0],
                 errors.height * std::sqrt(squares / static_cast<double>(touches.size())),
                 std::exp(p[5]) * (discs.opening - discs.fibre)};
    }
  return opening;
}

}  // namespace ferrule
