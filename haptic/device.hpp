// What holds the fibre: a haptic device with a person's hand on it, or a stand-in.
//
// A device is two functions, called in turn once per period:
//   sample = device.read(t)    where the hand is at time t
//   device.render(wrench)      what the hand feels at that time, less what there was at rest
// All in the hand's world (haptic/scaling.hpp). Neither may block longer than a period.
// A device with raw axes also says how they become that pose (mapping): a pen's axes are a
// position, the deflection of a SpaceMouse is a velocity that the device sums up.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "haptic/scaling.hpp"

namespace ferrule {

// X Y Z Rx Ry Rz as the device counts them; 0 for an axis it does not have.
inline constexpr std::size_t kRawAxes = 6;
using RawCounts = Eigen::Matrix<std::int32_t, kRawAxes, 1>;

struct HandSample {
  HandPose pose;                         // [m, rad]
  bool finished = false;                 // the operator is done with this episode
  const char* gave_up = nullptr;         // and why, where that is giving up
  bool lost = false;                     // the device is gone; then `finished` too
  RawCounts counts = RawCounts::Zero();  // that the pose, or its rate from t on, follows from
  double age = 0;        // of the pose [s], where the device reports all the time, moved or not
  bool stalled = false;  // the loop stood still before it: the device has ended its force by itself
};

// How raw axes become a pose. Each axis is first made a deflection from -1 to 1:
//   d = (count - centre) / limit, cut to +-1; 0 within the dead zone, which is taken off the rest
// and then, with d_0 the deflection at the start,
//   position   pose(t) = pose(0) + gain (d(t) - d_0)
//   velocity   pose rate over [t_n, t_n+1) = gain d(t_n)
struct Mapping {
  enum class Kind { position, velocity };
  Kind kind = Kind::position;
  std::array<double, kRawAxes> centre{}, limit{};  // [counts]; limit 0: no such axis
  double dead_zone = 0;                            // of the deflection [-], 0 <= dead_zone < 1
  // At full deflection: [m, rad] or [m/s, rad/s].
  Eigen::Matrix<double, 5, kRawAxes> gain = Eigen::Matrix<double, 5, kRawAxes>::Zero();

  Eigen::Matrix<double, kRawAxes, 1> deflection(const RawCounts& counts) const noexcept;
};

class Device {
 public:
  virtual ~Device() = default;
  // t [s] since the start of the episode; calls come with t rising by one period.
  virtual HandSample read(double t) = 0;
  // Force and moment of the fibre on the hand at the time of the last read, relative to those at
  // rest at the start, so that its weight does not matter [N, N m].
  virtual void render(const HandWrench& wrench) = 0;
  // Where the holder is at that time, before it renders: where the hand was read, but for errors of
  // the hand (sim/scene/scene.hpp) and a coupling. A stage has it from its encoders.
  virtual void holder_at(const HandPose&) {}
  // Null: it has no raw axes.
  virtual const Mapping* mapping() const noexcept { return nullptr; }
};

}  // namespace ferrule
