// A model of the firmware of the devices that haptic/ drives, for tests and for trying the program
// without a device. It is simulated: nobody's hand is on it.
//
// It is written from the bytes of each layout, not from the descriptor that it shows, so that it
// checks the descriptor-driven drivers; a report of the wrong length or content is refused. Its
// time stands still between calls of `advance`.
#pragma once

#include <array>
#include <deque>

#include "haptic/hid/driver.hpp"
#include "haptic/hid/report_descriptor.hpp"

namespace ferrule {

enum class FakeModel {
  space_mouse_split,     // reports 1 (X Y Z), 2 (Rx Ry Rz), 3 (buttons)
  space_mouse_combined,  // reports 1 (six axes), 3 (buttons)
  pid_18,  // Set Effect of 18 bytes: three times, directions of 8 bits; magnitude +-10000; Device
           // Control an array
  pid_22,  // Set Effect of 22 bytes: Start Delay too, directions to 36000; magnitude +-32767;
           // Device Control a bit mask; ids of its own
};

class FakeFirmware : public FakeTransport {
 public:
  // Room for `effects` effects (PID).
  explicit FakeFirmware(FakeModel model, int effects = 4);

  // What it tells the system about itself.
  static HidInfo describe(FakeModel model);

  int read(std::span<std::uint8_t> report, int timeout) noexcept override;
  bool write(std::span<const std::uint8_t> report) noexcept override;
  bool send_feature(std::span<const std::uint8_t> report) noexcept override;
  int get_feature(std::span<std::uint8_t> report) noexcept override;

  // A SpaceMouse reports every 8 ms while deflected and three times zero afterwards; a stick every
  // 1 ms.
  void advance(double t) override;
  void deflect(const std::array<int, 6>& counts) noexcept override { counts_ = counts; }
  void press(std::uint8_t buttons) override;

  void fall_silent(bool silent) noexcept { silent_ = silent; }
  void unplug() noexcept { unplugged_ = true; }

  // Force that its motors make now along X and Y, from -1 to 1 of what they can.
  std::array<double, 2> force() const noexcept;
  bool actuators() const noexcept { return enabled_; }
  int effects() const noexcept;  // in its memory
  bool light() const noexcept { return light_; }

  // Everything that was sent to it, in order.
  struct Sent {
    HidReportType type;
    std::vector<std::uint8_t> bytes;
  };
  const std::vector<Sent>& log() const noexcept { return log_; }

 private:
  struct Effect {
    bool used = false, constant = false;
    double duration = 0, until = -1;  // [s]
    double angle = 0;                 // clockwise from -Y [turns]
    double gain = 0, force = 0;
  };

  bool is_stick() const noexcept;
  void send(std::vector<std::uint8_t> report);
  void send_axes();
  bool take_output(std::span<const std::uint8_t> r) noexcept;
  bool control(int what) noexcept;
  Effect* effect(int block) noexcept;
  void reset() noexcept;

  FakeModel model_;
  std::vector<Effect> effects_;
  std::deque<std::vector<std::uint8_t>> waiting_;
  std::vector<Sent> log_;
  std::array<int, 6> counts_{};
  std::uint8_t buttons_ = 0;
  double time_ = 0, next_report_ = 0;
  int zeros_ = 0, loaded_ = 0;  // reports of zero still to send; block made last, 0: none
  bool second_ = false, silent_ = false, unplugged_ = false, enabled_ = false, light_ = false;
};

}  // namespace ferrule
