#include "view/browser_device.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace ferrule {

void BrowserHand::say(const HandMessage& message) noexcept {
  const Eigen::Vector3d v(message.velocity.data());
  const double cut = v.allFinite() ? 1 / std::max(1.0, v.norm()) : 0;
  std::array<std::int16_t, 3> counts{};
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const double share = cut > 0 ? cut * message.velocity[i] : 0;
    counts[i] = static_cast<std::int16_t>(std::lround(kFull * share));
  }
  say(counts, static_cast<std::uint8_t>(message.buttons & 0xff), message.sequence);
}

void BrowserHand::say(const std::array<std::int16_t, 3>& counts, bool button) noexcept {
  say(counts, static_cast<std::uint8_t>(button), 0);
}

void BrowserHand::say(const std::array<std::int16_t, 3>& counts, std::uint8_t buttons,
                      std::uint32_t sequence) noexcept {
  const Said now{counts, buttons, static_cast<std::uint8_t>(said().number + 1)};
  sequence_ = sequence;
  said_ = std::bit_cast<std::uint64_t>(now);
}

BrowserHand::Said BrowserHand::said() const noexcept {
  return std::bit_cast<Said>(said_.load());
}

BrowserDevice::BrowserDevice(const BrowserHand& page, double speed, const HandPose& start) noexcept
    : page_(page),
      pose_(start),
      heard_(-2 * kSilence),
      last_(page.said()),
      held_(last_.buttons),
      answered_(page.sequence()) {
  mapping_.kind = Mapping::Kind::velocity;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    mapping_.limit[axis] = BrowserHand::kFull;
    mapping_.gain(static_cast<Eigen::Index>(axis), static_cast<Eigen::Index>(axis)) = speed;
  }
}

HandSample BrowserDevice::read(double t) {
  pose_ += rate_ * (t - time_);
  time_ = t;
  const std::uint32_t sequence = page_.sequence();
  const BrowserHand::Said now = page_.said();
  if (now.number != last_.number) {
    heard_ = t;
    answered_ = sequence;
  }
  last_ = now;
  const bool silent = t - heard_ > kSilence;
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    counts_[axis] = silent ? 0 : now.counts[static_cast<std::size_t>(axis)];
  rate_ = mapping_.gain * mapping_.deflection(counts_);
  const bool pressed = now.buttons & ~held_;
  held_ &= now.buttons;
  return {pose_, pressed, nullptr, false, counts_};
}

}  // namespace ferrule
