// The device `browser`: a person's hand on mouse, keys or gamepad, by way of a page.
//
// Its deflection is a velocity, as that of a SpaceMouse: three axes of +-kFull counts, which the
// page sends as shares of full deflection. What it says is cut to the ball of radius 1, so that the
// hand is never faster than the speed that full deflection is. A page that is silent for longer
// than kSilence has let go: it stops, and goes on when the page does. Pressing a button ends the
// episode.
#pragma once

#include <atomic>

#include "haptic/device.hpp"
#include "view/message.hpp"

namespace ferrule {

inline constexpr const char* kBrowser = "browser";  // its name

// What a page said last, from the thread that hears it to the loop's, without locks.
class BrowserHand {
 public:
  static constexpr int kFull = 10000;  // counts at full deflection

  // In one thread.
  void say(const HandMessage& message) noexcept;
  // These counts, each within +-kFull; `button` is pressed or not.
  void say(const std::array<std::int16_t, 3>& counts, bool button) noexcept;

  struct Said {
    std::array<std::int16_t, 3> counts{};
    std::uint8_t buttons = 0;
    std::uint8_t number = 0;  // another with every message
  };
  // From any thread.
  Said said() const noexcept;
  // `sequence` of the last message.
  std::uint32_t sequence() const noexcept { return sequence_; }

 private:
  void say(const std::array<std::int16_t, 3>& counts, std::uint8_t buttons,
           std::uint32_t sequence) noexcept;

  std::atomic<std::uint64_t> said_ = 0;
  std::atomic<std::uint32_t> sequence_ = 0;
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
};

class BrowserDevice : public Device {
 public:
  static constexpr double kSilence = 0.2;  // [s]

  // `speed` of the hand at full deflection [m/s]; `page` outlives it. What the page said before
  // does not count.
  BrowserDevice(const BrowserHand& page, double speed, const HandPose& start) noexcept;

  HandSample read(double t) override;
  void render(const HandWrench&) override {}
  const Mapping* mapping() const noexcept override { return &mapping_; }

  // `sequence` of the message that it read last; from any thread.
  std::uint32_t answered() const noexcept { return answered_; }

 private:
  const BrowserHand& page_;
  Mapping mapping_;
  HandPose pose_;
  HandTwist rate_ = HandTwist::Zero();
  RawCounts counts_ = RawCounts::Zero();
  double time_ = 0, heard_ = 0;
  BrowserHand::Said last_;
  std::uint8_t held_;  // buttons since the start
  std::atomic<std::uint32_t> answered_ = 0;
};

}  // namespace ferrule
