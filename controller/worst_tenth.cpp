#include "controller/worst_tenth.hpp"

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

}  // namespace

std::vector<DrawnQuantity> drawn_quantities(const Scene& scene, std::uint64_t seed,
                                            std::size_t trials) {
  std::vector<DrawnQuantity> drawn = {{"start.lateral_um", {}}, {"start.tilt_mrad", {}}};
  for (const DrawnNumber& number : scene.drawn) drawn.push_back({number.key, {}});
  for (DrawnQuantity& quantity : drawn)
    quantity.values.assign(trials, std::numeric_limits<double>::quiet_NaN());
  for (std::size_t k = 0; k < trials; ++k) {
    const auto of_trial = draw_scene(scene, seed, k);
    if (!of_trial) continue;
    const Pose tip = draw_start(*of_trial, seed, k).tip;
    drawn[0].values[k] = tip.segment<2>(1).norm() / micro;
    drawn[1].values[k] = 1e3 * tip.tail<2>().norm();
    for (std::size_t i = 0; i < scene.drawn.size(); ++i)
      drawn[2 + i].values[k] = of_trial->document.at(pointer_to(scene.drawn[i].key)).get<double>();
  }
  return drawn;
}

WorstTenth worst_tenth(const std::vector<DrawnQuantity>& drawn,
                       const std::vector<TrialResult>& results) {
  WorstTenth worst{"", NAN, NAN, 0, 0};
  double least = std::numeric_limits<double>::infinity();
  for (const DrawnQuantity& quantity : drawn) {
    std::vector<std::size_t> even;
    for (std::size_t k = 0; k < results.size(); k += 2)
      if (std::isfinite(quantity.values[k])) even.push_back(k);
    if (even.size() < kTenths) continue;
    std::stable_sort(even.begin(), even.end(), [&](std::size_t a, std::size_t b) {
      return quantity.values[a] < quantity.values[b];
    });
    for (std::size_t part = 0; part < kTenths; ++part) {
      const std::size_t begin = part * even.size() / kTenths,
                        end = (part + 1) * even.size() / kTenths;
      const auto inserted = std::count_if(even.begin() + static_cast<std::ptrdiff_t>(begin),
                                          even.begin() + static_cast<std::ptrdiff_t>(end),
                                          [&](std::size_t k) { return succeeded(results[k]); });
      const double rate = static_cast<double>(inserted) / static_cast<double>(end - begin);
      if (!(rate < least)) continue;
      least = rate;
      worst = {quantity.name, quantity.values[even[begin]], quantity.values[even[end - 1]], 0, 0};
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
