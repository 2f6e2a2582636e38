#include "controller/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/base/random.hpp"

namespace ferrule {
namespace {

struct Pair {
  double f, again;
};

// Jansen's estimate, with the variance of all results of both; of the pairs that `at` tells.
template <class At>
double estimate(std::size_t n, const At& at) {
  double sum = 0, squares = 0, differences = 0;
  for (std::size_t k = 0; k < n; ++k) sum += at(k).f + at(k).again;
  const double mean = sum / (2 * static_cast<double>(n));
  for (std::size_t k = 0; k < n; ++k) {
    const double f = at(k).f - mean, again = at(k).again - mean;
    squares += f * f + again * again;
    differences += (f - again) * (f - again);
  }
  return squares > 0 ? differences / squares : NAN;
}

Interval bootstrap(const std::vector<Pair>& pairs, std::uint64_t seed) {
  constexpr int kSamples = 1000;
  RandomStream random(seed, 0, Draw::bootstrap);
  const std::size_t n = pairs.size();
  std::vector<double> estimates;
  std::vector<std::size_t> sample(n);
  for (int i = 0; i < kSamples; ++i) {
    for (std::size_t& k : sample) k = random.bits() % n;
    const double total = estimate(n, [&](std::size_t k) { return pairs[sample[k]]; });
    if (!std::isnan(total)) estimates.push_back(total);
  }
  return {quantile(estimates, 0.025), quantile(estimates, 0.975)};
}

}  // namespace

TotalIndex total_index(const std::vector<double>& f, const std::vector<double>& again,
                       std::uint64_t seed) {
  if (f.size() != again.size())
    throw std::invalid_argument("total_index: both must have the same number of trials");
  std::vector<Pair> pairs;
  for (std::size_t k = 0; k < f.size(); ++k)
    if (!std::isnan(f[k]) && !std::isnan(again[k])) pairs.push_back({f[k], again[k]});
  const auto of = [](const std::vector<Pair>& some) {
    return some.size() < 2 ? NAN : estimate(some.size(), [&](std::size_t k) { return some[k]; });
  };
  const double total = of(pairs);
  if (std::isnan(total)) return {NAN, {NAN, NAN}};
  if (total > 0) return {total, bootstrap(pairs, seed)};
  const auto [low, high] = std::minmax_element(
      pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) { return a.f < b.f; });
  const Pair farthest = {low->f, high->f};
  pairs.insert(pairs.end(), 3, farthest);
  return {0, {0, of(pairs)}};
}

}  // namespace ferrule
