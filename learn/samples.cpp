#include "learn/samples.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/random.hpp"

namespace ferrule {
namespace {

using Eigen::Vector3d;

constexpr double kLongestReaction = 0.4;  // [s]

// Share of the lateral velocities that is left after regression on what the law has for them: the
// force of `reaction` before, the depth and a constant.
double lateral_residual(const std::vector<const Demonstration*>& set, double reaction) {
  double variance = 0, residual = 0;
  for (const int axis : {1, 2}) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Vector3d product = Vector3d::Zero();
    double squares = 0, sum = 0, n = 0;
    for (const Demonstration* d : set)
      for (const Sample& s : samples(*d, reaction)) {
        const Vector3d x(s.force[axis], 1, 50 * s.depth);  // all of order one
        const double v = s.velocity[axis];
        normal += x * x.transpose();
        product += v * x;
        squares += v * v;
        sum += v;
        n += 1;
      }
    variance += squares - sum * sum / n;
    residual += squares - product.dot(normal.completeOrthogonalDecomposition().solve(product));
  }
  return variance > 0 ? residual / variance : 0;
}

}  // namespace

bool cut_to_limit(const Demonstration& d, Eigen::Index n) noexcept {
  return !(std::abs(d.velocity.row(n).norm() - d.speed_limit) > 1e-9 * d.speed_limit);
}

Samples samples(const Demonstration& d, double reaction) {
  const auto stride = std::max<Eigen::Index>(1, std::lround(kStep / d.period));
  const auto delay = static_cast<Eigen::Index>(std::lround(reaction / d.period));
  Samples all;
  for (Eigen::Index n = 0; n < d.time.size(); n += stride)
    if (!cut_to_limit(d, n))
      all.push_back({d.force.row(std::max<Eigen::Index>(0, n - delay)).transpose(),
                     d.velocity.row(n).transpose(), d.depth[n], d.time[n]});
  return all;
}

double reaction_time(const std::vector<const Demonstration*>& set) {
  double best = 0, least = lateral_residual(set, 0);
  for (int step = 1; step * kStep <= kLongestReaction + 1e-9; ++step) {
    const double residual = lateral_residual(set, step * kStep);
    if (residual < least) {
      least = residual;
      best = step * kStep;
    }
  }
  return best;
}

std::pair<std::vector<const Demonstration*>, std::vector<const Demonstration*>> split(
    const std::vector<Demonstration>& all, std::uint64_t seed) {
  // Every fifth of a shuffled list is held out.
  std::vector<std::size_t> order(all.size());
  std::iota(order.begin(), order.end(), 0u);
  RandomStream random(seed, 0, Draw::split);
  for (std::size_t i = order.size() - 1; i > 0; --i)
    std::swap(order[i], order[random.bits() % (i + 1)]);
  const std::size_t held = std::max<std::size_t>(1, all.size() / 5);
  std::vector<const Demonstration*> training, testing;
  for (std::size_t i = 0; i < order.size(); ++i)
    (i < held ? testing : training).push_back(&all[order[i]]);
  return {training, testing};
}

}  // namespace ferrule
