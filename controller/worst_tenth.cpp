#include "controller/worst_tenth.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/units.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kTenths = 10;

bool succeeded(const TrialResult& result) {
  return result.outcome == Outcome::inserted;
}

// Of every `stride`-th trial.
std::vector<Tenth> by_tenths(const DrawnQuantity& quantity, std::span<const TrialResult> results,
                             std::size_t stride) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < results.size(); k += stride)
    if (std::isfinite(quantity.values[k])) order.push_back(k);
  if (order.size() < kTenths) return {};
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return quantity.values[a] < quantity.values[b];
  });
  std::vector<Tenth> tenths;
  for (std::size_t part = 0; part < kTenths; ++part) {
    const std::size_t begin = part * order.size() / kTenths,
                      end = (part + 1) * order.size() / kTenths;
    Tenth tenth{quantity.values[order[begin]], quantity.values[order[end - 1]], 0, end - begin};
    for (std::size_t i = begin; i < end; ++i) tenth.successes += succeeded(results[order[i]]);
    tenths.push_back(tenth);
  }
  return tenths;
}

}  // namespace

std::vector<DrawnQuantity> drawn_quantities(const Scene& scene, std::uint64_t seed,
                                            std::size_t trials) {
  std::vector<DrawnQuantity> drawn = {{"start.lateral_um", {}}, {"start.tilt_mrad", {}}};
  for (const DrawnNumber& number : scene.drawn)
    if (number.shared.empty()) drawn.push_back({number.key, {}});
  for (DrawnQuantity& quantity : drawn)
    quantity.values.assign(trials, std::numeric_limits<double>::quiet_NaN());
  tbb::parallel_for(std::size_t{0}, trials, [&](std::size_t k) {
    const auto of_trial = draw_scene(scene, seed, k);
    if (!of_trial) return;
    const Pose tip = draw_start(*of_trial, seed, k).tip;
    drawn[0].values[k] = tip.segment<2>(1).norm() / micro;
    drawn[1].values[k] = 1e3 * tip.tail<2>().norm();
    for (const DecidedNumber& number : of_trial->decided)
      for (std::size_t i = 2; i < drawn.size(); ++i)
        if (drawn[i].name == number.key) drawn[i].values[k] = number.value;
  });
  return drawn;
}

Deciding deciding_quantity(const std::vector<DrawnQuantity>& drawn,
                           const std::vector<TrialResult>& results) {
  Deciding most{"", 0, {}};
  for (const DrawnQuantity& quantity : drawn) {
    const std::vector<Tenth> tenths = by_tenths(quantity, results, 1);
    double trials = 0, successes = 0, within = 0;
    for (const Tenth& tenth : tenths) {
      const auto n = static_cast<double>(tenth.trials), k = static_cast<double>(tenth.successes);
      trials += n;
      successes += k;
      within += k * (n - k) / n;
    }
    const double all = successes * (trials - successes) / trials;
    const double free = (trials - 1) / (trials - static_cast<double>(kTenths));
    const double share = 1 - within / all * free;
    // Not where nothing or everything succeeds, nor by rounding alone.
    if (share > most.share + 1e-12) most = {quantity.name, share, tenths};
  }
  return most;
}

WorstTenth worst_tenth(const std::vector<DrawnQuantity>& drawn,
                       std::span<const TrialResult> results) {
  WorstTenth worst;
  double least = std::numeric_limits<double>::infinity();
  for (const DrawnQuantity& quantity : drawn) {
    for (const Tenth& tenth : by_tenths(quantity, results, 2)) {
      const double rate = static_cast<double>(tenth.successes) / static_cast<double>(tenth.trials);
      if (!(rate < least)) continue;
      least = rate;
      worst = {quantity.name, tenth.low, tenth.high, 0, 0};
      for (std::size_t k = 1; k < results.size(); k += 2) {
        const double value = quantity.values[k];
        if (!(value >= worst.low && value <= worst.high)) continue;
        ++worst.trials;
        worst.successes += succeeded(results[k]);
      }
    }
  }
  return worst;
}

}  // namespace ferrule
