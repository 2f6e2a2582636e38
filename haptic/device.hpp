// What holds the fibre: a haptic device with a person's hand on it, or a stand-in.
//
// A device is two functions, called in turn once per period:
//   sample = device.read(t)    where the hand is at time t
//   device.render(wrench)      what the hand feels at that time
// All in the hand's world (haptic/scaling.hpp). Neither may block longer than a period.
#pragma once

#include "haptic/scaling.hpp"

namespace ferrule {

struct HandSample {
  HandPose pose;                  // [m, rad]
  bool finished = false;          // the operator is done with this episode
  const char* gave_up = nullptr;  // and why, where that is giving up
};

class Device {
 public:
  virtual ~Device() = default;
  // t [s] since the start of the episode; calls come with t rising by one period.
  virtual HandSample read(double t) = 0;
  // Force and moment of the fibre on the hand at the time of the last read [N, N m].
  virtual void render(const HandWrench& wrench) = 0;
};

}  // namespace ferrule
