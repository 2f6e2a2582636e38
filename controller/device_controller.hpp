// A device at the controller's place: so that an operator can be tried on the trials of a campaign,
// by himself and under a supervisor.
#pragma once

#include <memory>

#include "controller/controller.hpp"
#include "haptic/device.hpp"
#include "insertion/operator_skill.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// Commands the velocity of the device's hand over each `period` [s], and rests once the operator is
// finished. The device must begin at the pose the trial begins at.
class DeviceController : public Controller {
 public:
  DeviceController(std::unique_ptr<Device> device, double period)
      : device_(std::move(device)), period_(period), pose_(device_->read(0).pose) {}

  HandTwist command(const Observation& observation) noexcept override {
    device_->render(observation.wrench);
    const HandSample next = device_->read(static_cast<double>(++ticks_) * period_);
    HandTwist velocity =
        next.finished ? HandTwist(HandTwist::Zero()) : HandTwist((next.pose - pose_) / period_);
    pose_ = next.pose;
    return velocity;
  }

 private:
  std::unique_ptr<Device> device_;
  double period_;
  HandPose pose_;
  std::int64_t ticks_ = 0;
};

// In each trial under `seed` of `scene`, which must outlive it, a simulated operator of `skill`.
// Where the parts of a trial cannot be together, nobody moves.
MakeController simulated_operators(const Scene& scene, const OperatorSkill& skill,
                                   std::uint64_t seed);

}  // namespace ferrule
