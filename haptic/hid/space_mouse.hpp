// A 3Dconnexion SpaceMouse: six axes, no force.
//
// Its deflection is a velocity; this device sums it up into the hand's pose. It reports about every
// 8 ms, but only while deflected, then zero three times: if it falls silent after a report that was
// not zero, something is wrong, and the axes of that report count as zero until the next one.
// Axes come from the report descriptor, from the table of known devices where that does not tell.
// Declared are +-350 counts; up to about +-498 have been seen, so counts are cut. Ids and layouts
// are those of public captures.
#pragma once

#include "haptic/hid/driver.hpp"

namespace ferrule {

enum class SpaceMouseLayout { split, combined };

// Layout of a known device; empty for ids that are not in the table.
std::optional<SpaceMouseLayout> space_mouse_layout(std::uint16_t vendor,
                                                   std::uint16_t product) noexcept;
// Devices of the same makers that must never be taken for one: mice (CadMouse), receivers and
// keyboards.
bool never_a_space_mouse(std::uint16_t vendor, std::uint16_t product) noexcept;

// Axes of a device by its descriptor or, where that lacks one of the six, by its ids. Throws
// DeviceTrouble if neither tells.
AxisReader space_mouse_axes(const HidInfo& info);

// Full deflection is `speed` [m/s] along the axes and `tilt_rate` [rad/s] about them. The axes are
// those of the scene as it is looked at (sim/model/state.hpp's frame, z to the viewer): push the
// cap left to insert, lift it for up, pull it for towards the viewer; the tilts turn the same way
// round.
Mapping space_mouse_mapping(const AxisReader& axes, double speed, double tilt_rate) noexcept;

class SpaceMouse : public HidDevice {
 public:
  // Silence after a report that was not zero that counts as a fault [s]: six reports lost.
  static constexpr double kSilence = 0.05;

  // `transport` must outlive this. Reports that wait from before are taken as where it stands, so
  // that a button that is held down does not end the episode.
  SpaceMouse(HidTransport& transport, double speed, double tilt_rate, const HandPose& start);
  // Puts the light out.
  ~SpaceMouse() override;

  HandSample read(double t) override;
  void render(const HandWrench&) override {}
  const Mapping* mapping() const noexcept override { return &mapping_; }

  const AxisReader& axes() const noexcept override { return axes_; }
  int faults() const noexcept { return faults_; }  // silences so far

 private:
  HidTransport& transport_;
  AxisReader axes_;
  Mapping mapping_;
  HandPose pose_;
  HandTwist rate_ = HandTwist::Zero();
  double time_ = 0;
  std::uint32_t held_ = 0;  // buttons that have been down since the start
  bool lost_ = false;
  int faults_ = 0;
};

// Known ids, or a multi-axis controller (page 1, usage 8); not what never_a_space_mouse names.
extern const Driver kSpaceMouseDriver;

}  // namespace ferrule
