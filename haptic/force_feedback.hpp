// What lies between a person's hand and the fibre's holder, both ways, once per period:
//
//   hold   pose of the hand -> pose of the holder: the same, or with a virtual coupling what that
//          pulls along (haptic/virtual_coupling.hpp)
//   feel   wrench of the fibre on the holder -> wrench for the motors: through the coupling, the
//          passivity controller (haptic/passivity.hpp) and the guard (haptic/force_guard.hpp)
//
// Wrenches are relative to those at rest at the start: the fibre's weight is often more than a
// device can do. The bias of the scene's force sensor is taken off too, as the mean of the first
// kTare readings tells it; either would keep the guard waiting. A coupling pulls against the fibre
// itself; the sensor's errors are felt, and do not move the holder. Tilts and moments are not
// coupled. All in the hand's world.
#pragma once

#include <optional>

#include "haptic/force_guard.hpp"
#include "haptic/passivity.hpp"
#include "haptic/virtual_coupling.hpp"

namespace ferrule {

class ForceFeedback {
 public:
  static constexpr int kTare = 50;  // periods, without force

  // `coupling`: empty where the hand holds the fibre itself. `start`: where hand and holder begin.
  // `report_period`: as in GuardSettings. `motors`: 1 for x y z along which the device has one, 0
  // for the others, whose forces nobody feels and no energy follows from.
  ForceFeedback(const DeviceProfile& device, const std::optional<Coupling>& coupling,
                const HandPose& start, double report_period,
                const Eigen::Vector3d& motors = Eigen::Vector3d::Ones()) noexcept
      : hand_(start),
        motors_(motors),
        // A tenth of the limit that haptic/passivity.hpp states.
        passivity_(device.period, 0.1 * device.mass / device.period),
        guard_({.max_force = device.max_force,
                .period = device.period,
                .report_period = report_period}) {
    if (coupling) coupling_.emplace(*coupling, device.period, start.head<3>());
  }

  bool coupled() const noexcept { return coupling_.has_value(); }

  // `stiffness` of the fibre at the holder, -dF/dh [N/m, symmetric], where there is a coupling. A
  // pose that is not finite holds where it was.
  HandPose hold(const HandPose& hand, const Eigen::Matrix3d& stiffness) noexcept {
    const bool finite = hand.allFinite();
    if (!finite && !fault_) fault_ = "the hand's position is not a finite number";
    if (finite) hand_ = hand;
    HandPose holder = hand_;
    if (coupling_) holder.head<3>() = coupling_->move(hand_.head<3>(), fibre_, stiffness);
    return holder;
  }

  // Whether a hand pose that is `age` [s] old at time `now` [s] can be trusted. To be asked before
  // the fibre follows it: stepping to where no hand can be may take the simulator seconds.
  bool trusts(double now, double age, const HandPose& hand) noexcept {
    if (!fault_) fault_ = guard_.doubt(now, now - age, hand);
    return !fault_;
  }

  // At time `now` [s] with a hand pose that is `age` [s] old, after `hold`: the wrench of the
  // fibre, and what the sensor reads of it.
  HandWrench feel(double now, double age, const HandWrench& fibre,
                  const HandWrench& reading) noexcept {
    const HandWrench error = reading - fibre;
    const bool taring = readings_ < kTare;
    if (taring) bias_ += (error - bias_) / ++readings_;
    fibre_ = fibre.head<3>();
    HandWrench wanted = fibre;
    if (coupling_) wanted.head<3>() = coupling_->force();
    wanted += error - bias_;
    wanted.head<3>() = passivity_.pass(hand_.head<3>(), motors_.cwiseProduct(wanted.head<3>()));
    wanted.head<3>() = motors_.cwiseProduct(wanted.head<3>());
    const HandWrench allowed = guard_.pass(now, now - age, hand_, wanted);
    if (!fault_) fault_ = guard_.why();
    HandWrench acts = fault_ || taring ? HandWrench(HandWrench::Zero()) : allowed;
    passivity_.acts(acts.head<3>());
    return acts;
  }

  // As ForceGuard::ramp_again.
  void ramp_again(double now) noexcept { guard_.ramp_again(now); }

  // What could not be trusted; the wrench is zero from then on. Null: nothing yet.
  const char* fault() const noexcept { return fault_; }
  ForceGuard::Stage stage() const noexcept { return guard_.stage(); }
  // As PassivityController::energy [J].
  double energy() const noexcept { return passivity_.energy(); }

 private:
  HandPose hand_;
  Eigen::Vector3d motors_;
  HandWrench bias_ = HandWrench::Zero();
  int readings_ = 0;
  Eigen::Vector3d fibre_ = Eigen::Vector3d::Zero();  // on the holder [N]
  std::optional<VirtualCoupling> coupling_;
  PassivityController passivity_;
  ForceGuard guard_;
  const char* fault_ = nullptr;
};

}  // namespace ferrule
