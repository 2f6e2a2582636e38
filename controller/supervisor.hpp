// A supervisor around any controller: it passes the controller's velocities on as long as they keep
// the limits, and does what a careful operator does where they lead nowhere.
//
// Limits, in the hand's world, for every period T and every wrapped controller:
//   speed         |v| <= speed
//   acceleration  |u_n - u_n-1| <= acceleration T, from rest at the start; u = (v, lever omega):
//                 tilts count at a lever, by what they strain
//   force         the speed falls with what is left to the force it brakes for,
//                 F_b = min((1 - margin) force, force - misread):
//                   s^2 / (2 acceleration) + s T / 2 <= (F_b - F) / k,
//                 k the largest stiffness in the hand's world: a hand that brakes with the
//                 acceleration stops before F_b if the force rises by no more than k per metre.
//                 The part of v along the observed force f relieves it. In a retreat it is not
//                 braked, nor where it is the greater part of v: else braking the rest would turn
//                 the hand, and a late hand overshoot.
//                 F is what the force may be by now: |f| + k l, l the way of which a sensor of
//                 first order has not shown the force yet, l_n = (1 - follows) (l_n-1 + |u_n| T).
// Force wins over acceleration: where F + misread + k s T > force, the next period could exceed the
// limit itself; all but the relieving part is then stopped at once, however fast it was. A jerk can
// be mended, a broken fibre cannot. Nothing else exceeds the acceleration: stopping, retreating and
// giving up brake by it.
//
// Within contact laws that only resist (convex potentials) the force rises by at most k s T in a
// period, and the sensor has shown all of it but k l, so the true force exceeds no limit while the
// sensor errs by no more than `misread` beside its lag. A surface that snaps the fibre in can raise
// it without any motion of the hand; nobody can brake for that. A sensor whose `misread` leaves
// less than a quarter of the force to brake for is taken to err by less. A hand that is `late` goes
// on by v late after it was told to stop; nothing brakes for that. Where the sensor errs so, or
// k speed late exceeds what is left beyond F_b, the limit does not hold, and cannot_hold() says so.
//
// What leads nowhere:
//   held          the force held it below a tenth of the speed for `patience`
//   jam           for `patience` the controller pressed along -x with more than `jam_force`, and
//                 the tip advanced by less than half of what was commanded to the hand, or than a
//                 tenth of what the controller wanted: the advance is that of the encoder where it
//                 tells (in the bore), less what the holder was compressed. A controller that
//                 stops pressing sooner touches
//   disagreement  the controller's models disagreed by more than `disagreement` for `patience`;
//                 while they do, it goes slower by their ratio
// Then it goes back along the way it came by `retreat`, and tries again: after `held` and `jam`
// moved sideways by `offset` towards where the force pushed (where it pushed nowhere, in turn to
// directions 137.5 degrees apart), after `disagreement` at half the speed. After `tries` of these
// it stops and gives up. A velocity that is not finite makes it stop and give up at once.
#pragma once

#include <array>
#include <string>

#include "controller/controller.hpp"
#include "sim/base/control_period.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// Hand's world.
struct SupervisorLimits {
  double speed = 0;         // [m/s], > 0
  double force = 0;         // observed, less that at rest [N], > 0
  double acceleration = 0;  // [m/s^2], > 0
  double stiffness = 0;     // k: the largest in the hand's world [N/m], > 0
  double lever = 0;         // at which a tilt counts as a motion, by the force of both [m], > 0
  double margin = 0.1;      // of the force, kept free by braking [-], 0 to 1
  double follows = 1;  // of a step of the force, the sensor shows so much a period later, (0, 1]
  double misread = 0;  // by which the sensor errs beside its lag, hardly ever more [N], >= 0
  double late = 0;     // for which the holder goes on as it was told before [s], >= 0
  double disagreement = 0;         // [m/s], > 0
  double jam_force = 0;            // [N], > 0
  double patience = 0.5;           // [s], > 0
  double retreat = 0;              // [m], > 0
  double offset = 0;               // [m], > 0
  int tries = 8;                   // retreats before it gives up, >= 0
  double period = kControlPeriod;  // T [s], > 0

  double brakes_for() const noexcept;  // F_b [N], hand's world
};

// Of a scene: its speed and force limits and its holder's stiffness; the delay and smoothing of its
// hand, times its gain, as `late`; as `follows` what its sensor's bandwidth lets through in a
// period; as `misread` four standard deviations of the sensor's errors (at the force limit and the
// end of the longest trial), and its dead band with its resolution; acceleration to full speed in
// 2 ms (15 mm/s^2 for a tip that goes 30 um/s, little for any stage: with less, braking for a stiff
// holder takes most of the speed); a fifth of the speed as disagreement; a quarter of the force as
// that of a jam; at the tip a retreat of 20 um and offsets of 10 um.
SupervisorLimits supervisor_limits(const Scene& scene);

// Why a supervisor with these limits cannot hold the force limit; empty where it does, as above.
std::string cannot_hold(const SupervisorLimits& limits);

class Supervisor : public ControllerWrapper {
 public:
  Supervisor(std::unique_ptr<Controller> inner, const SupervisorLimits& limits);

  HandTwist command(const Observation& observation) noexcept override;
  const Supervision* supervision() const noexcept override { return &supervision_; }

 private:
  enum class Phase { follow, retreat, shift, stop };
  static constexpr std::size_t kWay = 256;  // points of the way that it remembers
  static constexpr int kPerRetreat = 32;    // points of a retreat

  HandTwist follow(const Observation& observation, HandTwist wanted) noexcept;
  bool jammed(const Observation& observation, const HandTwist& wanted) noexcept;
  void give_way(Intervention why, const Observation& observation) noexcept;
  void stop(Intervention why) noexcept;
  void remember_way() noexcept;
  HandTwist go_back(const Observation& observation) noexcept;
  HandTwist keep_limits(const HandTwist& wanted, const Eigen::Vector3d& force) noexcept;
  double speed_within(double distance, double lag = 0) const noexcept;
  double by_now(const Eigen::Vector3d& force) const noexcept;
  double braked_speed(double force) const noexcept;
  void note(Intervention kind, bool now) noexcept;

  SupervisorLimits limits_;
  double stoppable_;  // |u| that can be braked for where nothing is felt [m/s]
  double fastest_;    // that, or `speed` if less [m/s]
  Supervision supervision_;
  std::array<bool, kInterventions> going_on_{};

  Phase phase_ = Phase::follow;
  Intervention reason_{};  // to stop
  // Tilts times the lever in these.
  HandTwist velocity_ = HandTwist::Zero();  // over the last period
  HandPose pose_ = HandPose::Zero();        // relative to the start
  double unseen_ = 0;               // way of which the sensor has not shown the force yet [m]
  std::array<HandPose, kWay> way_;  // ring of where it came along
  std::size_t way_end_ = 0, way_length_ = 0;
  HandPose aside_ = HandPose::Zero();  // the shift after a retreat
  HandPose goal_ = HandPose::Zero();   // and where that leads

  int tries_ = 0, searches_ = 0;
  int to_go_ = 0;                                  // points of the way that a retreat still takes
  double phase_end_ = 0;                           // a retreat that is stuck ends here [s]
  double slower_ = 1;                              // factor on the speed after disagreement
  double held_since_ = -1, disagreed_since_ = -1;  // [s]; < 0: not now
  Eigen::Vector2d searched_ = Eigen::Vector2d::Zero();  // sideways, where nothing pushed [m]
  // Since it presses: depth and force then, the ways along -x that were commanded and wanted.
  double pressed_since_ = -1;  // [s]; < 0: it does not
  double depth_then_ = 0, force_then_ = 0, commanded_ = 0, wanted_ = 0;
};

// A supervisor with its own copy of the controller for every trial.
MakeController supervised(const MakeController& make, const SupervisorLimits& limits);

}  // namespace ferrule
