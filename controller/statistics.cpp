#include "controller/statistics.hpp"

#include <algorithm>
#include <boost/math/distributions/binomial.hpp>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <limits>

namespace ferrule {

namespace {

// tail/point; where the point is too unlikely for a double, what that goes to on its side.
double evidence(double tail, double point, bool on_its_side) {
  if (point > 0) return tail / point;
  return on_its_side ? std::numeric_limits<double>::infinity() : 0;
}

}  // namespace

double two_sided_z() {
  return boost::math::quantile(boost::math::normal(), 0.975);
}

Interval wilson(std::size_t successes, std::size_t trials) {
  const double z = two_sided_z();
  const double n = static_cast<double>(trials), p = static_cast<double>(successes) / n;
  const double centre = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {successes == 0 ? 0.0 : std::max(0.0, centre - half),
          successes == trials ? 1.0 : std::min(1.0, centre + half)};
}

// The interval is what the score test does not reject: its lower end is `rate` where
// (p - rate)^2 = z^2 rate (1 - rate)/n.
std::optional<std::size_t> trials_to_show(double rate, std::size_t successes, std::size_t trials) {
  const double z = two_sided_z();
  const double above = static_cast<double>(successes) / static_cast<double>(trials) - rate;
  if (!(above > 0)) return std::nullopt;
  const auto all = static_cast<std::size_t>(std::ceil(z * z * rate * (1 - rate) / (above * above)));
  return all > trials ? all - trials : 0;
}

double evidence_above(double rate, std::size_t successes, std::size_t trials) {
  const auto n = static_cast<double>(trials), s = static_cast<double>(successes);
  const boost::math::binomial now(n, rate), next(n + 1, rate);
  return evidence(cdf(next, s), (n + 1) * (1 - rate) * pdf(now, s), s > rate * n);
}

double evidence_below(double rate, std::size_t successes, std::size_t trials) {
  const auto n = static_cast<double>(trials), s = static_cast<double>(successes);
  const boost::math::binomial now(n, rate), next(n + 1, rate);
  return evidence(cdf(complement(next, s)), (n + 1) * rate * pdf(now, s), s < rate * n);
}

double mcnemar_p(std::size_t only_a, std::size_t only_b) {
  if (only_a + only_b == 0) return 1;
  const boost::math::binomial pairs(static_cast<double>(only_a + only_b), 0.5);
  return std::min(1.0, 2 * cdf(pairs, static_cast<double>(std::min(only_a, only_b))));
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double place = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const auto above = std::min(below + 1, values.size() - 1);
  return values[below] + (place - static_cast<double>(below)) * (values[above] - values[below]);
}

Interval median_interval(std::vector<double> values) {
  constexpr double kTail = 0.025;
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  // The largest number of values outside on either side whose chance is no more than the tail.
  const boost::math::binomial below(static_cast<double>(values.size()), 0.5);
  std::size_t outside = 0;
  while (outside < values.size() / 2 && cdf(below, static_cast<double>(outside)) <= kTail)
    ++outside;
  if (outside == 0) return {kNone, kNone};
  std::sort(values.begin(), values.end());
  return {values[outside - 1], values[values.size() - outside]};
}

}  // namespace ferrule
