#include "controller/sensitivity.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/base/random.hpp"

namespace ferrule {
namespace {

// Results of a trial: f, f' and g.
struct Trial {
  double f, again, all_again;
};

struct Moments {
  double mean = 0, variance = 0;
};

// Of f and f' of the n trials that `at` tells.
template <class At>
Moments moments(std::size_t n, const At& at) {
  Moments m;
  const double count = 2 * static_cast<double>(n);
  double sum = 0, squares = 0;
  for (std::size_t k = 0; k < n; ++k) sum += at(k).f + at(k).again;
  m.mean = sum / count;
  for (std::size_t k = 0; k < n; ++k) {
    const double f = at(k).f - m.mean, again = at(k).again - m.mean;
    squares += f * f + again * again;
  }
  m.variance = squares / count;
  return m;
}

// NaN where all results are the same.
template <class At>
double total(std::size_t n, const At& at) {
  const double variance = moments(n, at).variance;
  double sum = 0;
  for (std::size_t k = 0; k < n; ++k)
    sum += (at(k).f - at(k).again) * (at(k).f - at(k).again) / static_cast<double>(n);
  return variance > 0 ? sum / (2 * variance) : NAN;
}

template <class At>
double first_order(std::size_t n, const At& at) {
  const Moments m = moments(n, at);
  double sum = 0;
  for (std::size_t k = 0; k < n; ++k)
    sum += (at(k).all_again - m.mean) * (at(k).again - at(k).f) / static_cast<double>(n);
  return m.variance > 0 ? sum / m.variance : NAN;
}

template <class Estimate>
Interval bootstrap(const std::vector<Trial>& trials, std::uint64_t seed, const Estimate& estimate) {
  constexpr int kSamples = 1000;
  RandomStream random(seed, 0, Draw::bootstrap);
  const std::size_t n = trials.size();
  std::vector<double> estimates;
  std::vector<std::size_t> sample(n);
  for (int i = 0; i < kSamples; ++i) {
    for (std::size_t& k : sample) k = random.bits() % n;
    const double one = estimate(n, [&](std::size_t k) { return trials[sample[k]]; });
    if (!std::isnan(one)) estimates.push_back(one);
  }
  return {quantile(estimates, 0.025), quantile(estimates, 0.975)};
}

template <class Estimate>
SobolIndex index_of(std::vector<Trial> trials, std::uint64_t seed, const Estimate& estimate) {
  const auto of_all = [&](const auto& by) {
    return by(trials.size(), [&](std::size_t k) { return trials[k]; });
  };
  const double index = trials.size() < 2 ? NAN : of_all(estimate);
  if (std::isnan(index)) return {NAN, {NAN, NAN}};
  if (std::any_of(trials.begin(), trials.end(), [](const Trial& t) { return t.f != t.again; }))
    return {index, bootstrap(trials, seed, estimate)};
  const auto [low, high] = std::minmax_element(
      trials.begin(), trials.end(), [](const Trial& a, const Trial& b) { return a.f < b.f; });
  const Trial farthest = {low->f, high->f, low->all_again};
  trials.insert(trials.end(), 3, farthest);
  return {0, {0, of_all([](std::size_t n, const auto& at) { return total(n, at); })}};
}

void expect_as_many(std::size_t a, std::size_t b) {
  if (a != b) throw std::invalid_argument("Sobol indices: all must have the same number of trials");
}

}  // namespace

SobolIndex total_index(const std::vector<double>& f, const std::vector<double>& again,
                       std::uint64_t seed) {
  expect_as_many(f.size(), again.size());
  std::vector<Trial> trials;
  for (std::size_t k = 0; k < f.size(); ++k)
    if (!std::isnan(f[k]) && !std::isnan(again[k])) trials.push_back({f[k], again[k], NAN});
  return index_of(std::move(trials), seed,
                  [](std::size_t n, const auto& at) { return total(n, at); });
}

SobolIndex first_order_index(const std::vector<double>& f, const std::vector<double>& again,
                             const std::vector<double>& all_again, std::uint64_t seed) {
  expect_as_many(f.size(), again.size());
  expect_as_many(f.size(), all_again.size());
  std::vector<Trial> trials;
  for (std::size_t k = 0; k < f.size(); ++k)
    if (!std::isnan(f[k]) && !std::isnan(again[k]) && !std::isnan(all_again[k]))
      trials.push_back({f[k], again[k], all_again[k]});
  return index_of(std::move(trials), seed,
                  [](std::size_t n, const auto& at) { return first_order(n, at); });
}

}  // namespace ferrule
