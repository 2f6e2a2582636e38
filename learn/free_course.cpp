#include "learn/free_course.hpp"

#include <algorithm>
#include <cmath>

#include "learn/intervals.hpp"
#include "learn/normal_equations.hpp"

namespace ferrule {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// The places of the gains that yield along an axis.
std::vector<std::size_t> yields_along(LawKind kind, char axis) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < gain_table(kind).size(); ++i)
    if (std::string_view(gain_table(kind)[i].name).ends_with(std::string("yield_") + axis))
      places.push_back(i);
  return places;
}

// Between which as many rows lie; fewer where the hand rests.
std::vector<double> knots(const std::vector<Samples>& episodes) {
  std::vector<double> heights;
  for (const Samples& episode : episodes)
    for (const Sample& sample : episode) heights.push_back(sample.height);
  std::sort(heights.begin(), heights.end());
  std::vector<double> all;
  for (std::size_t k = 0; k < kCourseKnots; ++k) {
    const double height = heights[k * (heights.size() - 1) / (kCourseKnots - 1)];
    if (all.empty() || height > all.back()) all.push_back(height);
  }
  return all;
}

// The rows of one episode, from when the hand begins: the derivatives to the yields, the course's
// hat functions, and in the last column the velocity beside the law's own course.
MatrixXd rows_of(LawKind kind, std::vector<double> gains, const std::vector<std::size_t>& yields,
                 int axis, const std::vector<double>& at, const Samples& episode) {
  const auto n = static_cast<Index>(yields.size()), hats = static_cast<Index>(at.size());
  MatrixXd rows = MatrixXd::Zero(static_cast<Index>(episode.size()), n + hats + 1);
  for (const std::size_t k : yields) gains[k] = 0;
  Index count = 0;
  for (const Sample& sample : episode) {
    if (sample.velocity.isZero(0)) continue;
    auto row = rows.row(count++);
    const auto velocity = [&] { return law_velocity(kind, gains.data(), sample)[axis]; };
    const double without = velocity();
    for (Index k = 0; k < n; ++k) {
      double& gain = gains[yields[static_cast<std::size_t>(k)]];
      gain = 1;
      row[k] = velocity() - without;
      gain = 0;
    }
    const auto above = std::upper_bound(at.begin(), at.end(), sample.height) - at.begin();
    const Index right = std::clamp<Index>(above, 1, hats - 1);
    const double low = at[static_cast<std::size_t>(right - 1)],
                 high = at[static_cast<std::size_t>(right)],
                 s = std::clamp((sample.height - low) / (high - low), 0.0, 1.0);
    row[n + right - 1] = 1 - s;
    row[n + right] = s;
    row[n + hats] = sample.velocity[axis] - without;
  }
  return rows.topRows(count);
}

}  // namespace

FreeCourse free_course(LawKind kind, const std::vector<double>& gains,
                       const std::vector<Samples>& episodes) {
  FreeCourse free{std::vector<FittedGain>(gains.size(), {NAN, NAN, NAN})};
  const std::vector<double> at = knots(episodes);
  if (at.size() < 2) return free;
  const auto hats = static_cast<Index>(at.size());
  for (const int axis : {1, 2}) {
    const std::vector<std::size_t> yields = yields_along(kind, "xyz"[axis]);
    const Index n = static_cast<Index>(yields.size()) + hats;
    std::vector<MatrixXd> rows;
    MatrixXd information = MatrixXd::Zero(n, n);
    VectorXd product = VectorXd::Zero(n);
    for (const Samples& episode : episodes) {
      rows.push_back(rows_of(kind, gains, yields, axis, at, episode));
      information += rows.back().leftCols(n).transpose() * rows.back().leftCols(n);
      product += rows.back().leftCols(n).transpose() * rows.back().col(n);
    }
    const VectorXd all = least_squares(information, product),
                   course =
                       least_squares(information.bottomRightCorner(hats, hats), product.tail(hats));
    double left = 0, left_by_course = 0;
    std::vector<EpisodeSums> sums;
    for (const MatrixXd& one : rows) {
      const VectorXd error = one.col(n) - one.leftCols(n) * all;
      left += error.squaredNorm();
      left_by_course += (one.col(n) - one.middleCols(n - hats, hats) * course).squaredNorm();
      sums.emplace_back(n);
      sums.back().information = one.leftCols(n).transpose() * one.leftCols(n);
      sums.back().score = one.leftCols(n).transpose() * error;
    }
    free.share[axis] = left_by_course > 0 ? 1 - left / left_by_course : 0;
    const VectorXd half =
        precision(sums, std::vector<bool>(static_cast<std::size_t>(n), false)).half_width;
    for (std::size_t k = 0; k < yields.size(); ++k) {
      const double value = all[static_cast<Index>(k)], h = half[static_cast<Index>(k)];
      free.yields[yields[k]] = {value, value - h, value + h};
    }
  }
  return free;
}

std::vector<double> determined(const FreeCourse& free) {
  std::vector<double> values;
  for (const FittedGain& yield : free.yields)
    values.push_back(yield.high - yield.value < kDetermined * yield.value ? yield.value : NAN);
  return values;
}

std::vector<FittedGain> with_yields(std::vector<FittedGain> gains, const FreeCourse& free) {
  const std::vector<double> values = determined(free);
  for (std::size_t i = 0; i < gains.size(); ++i) {
    FittedGain& gain = gains[i];
    const FittedGain& other = free.yields[i];
    if (std::isnan(gain.low) || std::isnan(other.low)) continue;
    const FittedGain own = std::isnan(values[i]) ? gain : other;
    gain = {own.value, std::min(own.low, other.low), std::max(own.high, other.high)};
    for (const double value : {own.value, other.value}) {
      gain.low = std::max(0.0, std::min(gain.low, value - kLeastError * std::abs(value)));
      gain.high = std::max(gain.high, value + kLeastError * std::abs(value));
    }
  }
  return gains;
}

}  // namespace ferrule
