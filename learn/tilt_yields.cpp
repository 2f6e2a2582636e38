#include "learn/tilt_yields.hpp"

#include <algorithm>

#include "learn/free_course.hpp"
#include "learn/intervals.hpp"

namespace ferrule {
namespace {

bool rests(const Sample& sample) noexcept {
  return sample.velocity.isZero(0) && sample.tilt_rate.isZero(0);
}

}  // namespace

TiltYields tilt_yields(const std::vector<Samples>& episodes) {
  Eigen::Array2d moments = Eigen::Array2d::Zero(), product = moments, rates = moments;
  for (const Samples& episode : episodes)
    for (const Sample& s : episode) {
      if (rests(s)) continue;
      const Eigen::Array2d moment = s.wrench.tail<2>(), rate = s.tilt_rate;
      moments += moment.square();
      product += moment * rate;
      rates += rate.square();
    }
  if (!(rates.sum() > 0)) return {};
  const Eigen::Array2d yield = (moments > 0).select(product / moments, 0).max(0);
  TiltYields yields{(yield * (2 * product - yield * moments)).sum() / rates.sum()};
  if (!(yields.share >= kLeastToldByMoments)) return yields;
  for (int about = 0; about < 2; ++about) {
    std::vector<EpisodeSums> sums;
    for (const Samples& episode : episodes) {
      sums.emplace_back(1);
      for (const Sample& s : episode) {
        if (rests(s)) continue;
        const double moment = s.wrench[3 + about];
        sums.back().information(0, 0) += moment * moment;
        sums.back().score[0] += moment * (s.tilt_rate[about] - yield[about] * moment);
      }
    }
    yields.gains.push_back({.value = yield[about]});
    if (!(yield[about] > 0)) continue;  // at its bound
    const double half =
        std::max(precision(sums, {false}).half_width[0], kLeastError * yield[about]);
    yields.gains.back().low = std::max(0.0, yield[about] - half);
    yields.gains.back().high = yield[about] + half;
  }
  return yields;
}

}  // namespace ferrule
