// A simulated operator: a trainee of a given skill at the haptic device.
//
// It intends a minimum-jerk motion along -x (Flash and Hogan 1985),
//   x(p) = x_0 - D (10 p^3 - 15 p^4 + 6 p^5),   phase p from 0 to 1,
// feels the force on its hand with a delay, and answers it:
//   lateral velocity  v_y = a A (f_y - F_p), v_z = a A f_z    yields to the force, but for a light
//                                                         press F_p downwards that keeps the fibre
//                                                         on the lower side; sets in at phase 0.7
//   rates of tilt     w_y = C M_y, w_z = C M_z            yields to the moments
//   before the entrance, where the task has an aim that the eye sees, steers onto it: of the way
//                       sideways that is left it makes the part that a minimum-jerk motion makes,
//                         dy = (y_aim - y) (m(s + ds) - m(s))/(1 - m(s)),  m(s) = 10 s^3 - ...,
//                       s the part made of the way along -x up to there
//   phase speed       dp/dt = g / (T (1 + |f|^2 / F_s^2))   slows down where the force is large
// with g the drive, which falls from 1 towards 0 while it hesitates; on top comes tremor
// (haptic/unsteady_hand.hpp). By place, force and phase of the intention it yields by
//   a = b (1 + (a_f - 1) u/(1 + u)) (1 + (a_p - 1) p),   u = |f|^2/F_s^2
// times as much, b being 1 outside the bore and a_b inside.
// `skill` from 0 to 1 moves all traits together (trainee_traits), but for those that are 1 or 0 at
// any skill.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "haptic/device.hpp"
#include "haptic/unsteady_hand.hpp"

namespace ferrule {

struct TraineeTraits {
  double delay;            // [s], 0.25 at skill 0 to 0.15 at skill 1
  double peak_speed;       // of the intended motion, relative to the task's speed [-], 0.7 to 1
  double yield;            // A [m/s per N], 0.5e-3 to 1e-3
  double slowing_force;    // F_s [N], 1.5 to 3
  double tremor;           // amplitude of the hand's displacement per axis [m], 8e-6 to 1e-6
  double hesitation_rate;  // beginnings per second [1/s], 0.3 to 0.02
  double bore_yield = 1;   // a_b: of A inside the bore [-]
  double force_yield = 1;  // a_f: of A under a force much larger than F_s [-]
  double late_yield = 1;   // a_p: of A at the end of the motion [-]
  double tilt_yield = 0;   // C [rad/s per N m]
};

// A trait by its name, and its range in the trait's unit.
struct Trait {
  const char* name;
  double TraineeTraits::*value;
  double low, high;
};
inline constexpr auto kTraits = std::to_array<Trait>({
    {"delay", &TraineeTraits::delay, 0.001, 1},
    {"peak_speed", &TraineeTraits::peak_speed, 0.01, 1},
    {"yield", &TraineeTraits::yield, 0, 0.1},
    {"slowing_force", &TraineeTraits::slowing_force, 0.01, 1e3},
    {"tremor", &TraineeTraits::tremor, 0, 1e-3},
    {"hesitation_rate", &TraineeTraits::hesitation_rate, 0, 10},
    {"bore_yield", &TraineeTraits::bore_yield, 0, 100},
    {"force_yield", &TraineeTraits::force_yield, 0, 100},
    {"late_yield", &TraineeTraits::late_yield, 0, 100},
    {"tilt_yield", &TraineeTraits::tilt_yield, 0, 1},
});

// Linear in `skill`, 0 <= skill <= 1.
TraineeTraits trainee_traits(double skill) noexcept;

// A line along x that the hand is steered onto within a distance.
struct TraineeAim {
  double within;            // along -x from the start [m], > 0
  Eigen::Vector2d lateral;  // y and z of the hand there [m]
};

// What the trainee is asked to do, in the hand's world.
struct TraineeTask {
  HandPose start;   // pose at rest at t = 0 [m, rad]
  double distance;  // D, along -x [m], > 0
  double speed;     // speed that a skilled operator peaks at [m/s], > 0
  double press;     // F_p at the end of the motion [N], >= 0
  double period;    // between reads [s], > 0
  // From the start along -x to where it takes the entrance to be [m].
  double entrance = std::numeric_limits<double>::infinity();
  std::optional<TraineeAim> aim = {};  // empty: it keeps its line
};

class Trainee : public Device {
 public:
  // `uniform` is its source of chance: independent numbers in (0, 1).
  Trainee(const TraineeTraits& traits, const TraineeTask& task, std::function<double()> uniform);

  HandSample read(double t) override;
  void render(const HandWrench& wrench) override;

  // What it would do at time t if its hand had been led to `pose` and rendered `wrench`: its
  // velocity until the next tick, with the phase of its intention set by how far along -x the hand
  // is [m/s, rad/s]. Instead of read and render, once per period.
  HandTwist answer(double t, const HandPose& pose, const HandWrench& wrench);

 private:
  void advance_intention(double force) noexcept;
  double yield(double force) const noexcept;
  Eigen::Vector2d steering() const noexcept;

  TraineeTraits traits_;
  TraineeTask task_;
  UnsteadyHand hand_;
  HandPose pose_;
  HandTwist velocity_ = HandTwist::Zero();
  double time_ = 0;
  double phase_ = 0, speed_ = 0;  // p and the intended speed along -x [m/s]
  double finished_at_ = -1;
  std::vector<HandWrench> felt_;  // ring: of the last `delay` seconds [N, N m]
  std::size_t next_ = 0;
};

}  // namespace ferrule
