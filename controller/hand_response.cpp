#include "controller/hand_response.hpp"

#include <algorithm>

namespace ferrule {
namespace {

constexpr double kMeasuredTime = 0.25;  // so long it is measured [s]
constexpr double kMeasuredDelays = 5;   // and at least so many times its delay
constexpr double kMostGain = 2;         // or its inverse: what moves less is held back

}  // namespace

void HandResponse::moved(double way, double time, double speed) noexcept {
  if (measured_) return;
  if (time >= 2 * marks_[1].time) marks_ = {marks_[1], {time, way}};
  const auto [before, from] = marks_[0];
  if (!(way > from && time > before)) return;
  const double reached = (way - from) / (time - before);
  delay_ = std::max(0.0, time - way / reached);
  measured_ = time > std::max(kMeasuredTime, kMeasuredDelays * delay_);
  if (measured_) gain_ = std::clamp(reached / speed, 1 / kMostGain, kMostGain);
}

}  // namespace ferrule
