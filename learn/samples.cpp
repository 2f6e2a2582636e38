#include "learn/samples.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "learn/normal_equations.hpp"
#include "learn/shuffle.hpp"

namespace ferrule {
namespace {

using Eigen::Matrix4d;
using Eigen::Vector3d;
using Eigen::Vector4d;

constexpr double kLongestReaction = 0.4;  // [s]
constexpr double kLeastForce = 0.001;  // standard deviation of felt force that tells anything [N]

// Share of the lateral velocities that is left after regression on what the laws have for them: the
// force of `reaction` before, outside the bore and inside, the depth and a constant.
double lateral_residual(const std::vector<const Demonstration*>& set, double reaction) {
  double variance = 0, residual = 0;
  for (const int axis : {1, 2}) {
    Matrix4d normal = Matrix4d::Zero();
    Vector4d product = Vector4d::Zero();
    double squares = 0, sum = 0, n = 0;
    for (const Demonstration* d : set)
      for (const Sample& s : samples(*d, reaction)) {
        const double force = s.wrench[axis];
        const bool inside = s.depth > 0;
        const Vector4d x(inside ? 0 : force, inside ? force : 0, 1, 50 * s.depth);  // of order one
        const double v = s.velocity[axis];
        normal += x * x.transpose();
        product += v * x;
        squares += v * v;
        sum += v;
        n += 1;
      }
    variance += squares - sum * sum / n;
    residual += squares - product.dot(least_squares(normal, product));
  }
  return variance > 0 ? residual / variance : 0;
}

}  // namespace

bool cut_to_limit(const Demonstration& d, Eigen::Index n) noexcept {
  return !(std::abs(d.velocity.row(n).norm() - d.speed_limit) > 1e-9 * d.speed_limit);
}

Samples samples(const Demonstration& d, double reaction) {
  const Eigen::Index stride = rows_per_step(d.period);
  const auto delay = static_cast<Eigen::Index>(std::lround(reaction / d.period));
  Samples all;
  all.reserve(static_cast<std::size_t>((d.rows() + stride - 1) / stride));
  for (Eigen::Index n = 0; n < d.rows(); n += stride) {
    if (cut_to_limit(d, n)) continue;
    all.push_back({d.observed(n), d.velocity.row(n).transpose(), d.tilt_rates.row(n).transpose()});
    all.back().wrench = d.observed(n - delay).wrench;
  }
  return all;
}

Samples thinned(const Samples& samples, std::size_t stride) {
  Samples some;
  for (std::size_t n = 0; n < samples.size(); n += stride) some.push_back(samples[n]);
  return some;
}

Split split(const std::vector<Demonstration>& all, std::uint64_t seed) {
  const std::vector<std::size_t> order = shuffled(all.size(), seed);
  const std::size_t held = std::max<std::size_t>(1, all.size() / 5);
  Split s;
  for (std::size_t i = 0; i < order.size(); ++i)
    (i < held ? s.testing : s.training).push_back(&all[order[i]]);
  return s;
}

double reaction_time(const std::vector<const Demonstration*>& demonstrations) {
  double best = 0, least = lateral_residual(demonstrations, 0);
  for (int step = 1; step * kStep <= kLongestReaction + 1e-9; ++step) {
    const double residual = lateral_residual(demonstrations, step * kStep);
    if (residual < least) {
      least = residual;
      best = step * kStep;
    }
  }
  return best;
}

void refuse_uninformative(const std::vector<Samples>& episodes) {
  std::size_t rows = 0;
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) {
      ++rows;
      sum += s.wrench.head<3>();
      squares += s.wrench.head<3>().cwiseAbs2();
    }
  if (rows < kFewestRows)
    throw BadInput(fmt::format("too little data: {} rows in steps of 10 ms; {} are needed", rows,
                               kFewestRows));
  const double n = static_cast<double>(rows);
  const Vector3d sd = (squares / n - (sum / n).cwiseAbs2()).cwiseMax(0.0).cwiseSqrt();
  for (const int axis : {1, 2})
    if (sd[axis] < kLeastForce)
      throw BadInput(fmt::format(
          "the demonstrations tell nothing about the answer to force: the felt F_{} varies by "
          "{:.2g} N (standard deviation), {} N is needed; record misaligned starts",
          "xyz"[axis], sd[axis], kLeastForce));
  double depth = 0, speed = 0;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) {
      depth = std::max(depth, s.depth);
      speed = std::max(speed, s.velocity.norm());
    }
  if (!(depth > 0) || !(speed > 0))
    throw BadInput("the demonstrations tell nothing about insertion: the hand never went in");
}

}  // namespace ferrule
