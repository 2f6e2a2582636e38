// An insertion that finds the bore by touch, without learning. It needs the axial force, tilt as an
// action, and its own motion remembered; no moments before it is in the bore.
//
//   approach     straight in, slower near where the entrance is taken to be, until it is felt: an
//                axial force above F_t, or above what the sensor's noise in free air ever reaches
//   touch        rests for t_h and takes the mean axial force f; the end is at x = x_hand + f/k.
//                The first time it gives way (release) until less than half of f is left, and rests
//                again: that gives the stiffness k.
//   lift         off by l, further where something still holds it; move to the next place (touch
//                search); lower: fast where nothing can be in the way, then at the touching speed.
//                An end that comes lower than the face lets it is in the opening.
//   insert       v_x = -v_i (1 - |f|^2/F_p^2), not backwards, v_y = A f_y, v_z = A f_z, upright.
//                Held up at the face it touches there; held up in the bore:
//   straighten   backs off by l and tilts to one side and to the other until the bore resists with
//                a moment M_t, about each axis, and inserts on in the middle.
//
// Forces are relative to their mean in free air. Lengths and speeds are of the hand.
#pragma once

#include <array>
#include <span>

#include "controller/controller.hpp"
#include "controller/gain.hpp"
#include "controller/touch_search.hpp"

namespace ferrule {

inline constexpr std::array kSearchGains = std::to_array<Gain>({
    {"approach_speed", "v_a", "m/s", Gain::positive},
    {"touch_speed", "v_t", "m/s", Gain::positive},
    {"insert_speed", "v_i", "m/s", Gain::positive},
    {"tilt_rate", "w", "rad/s", Gain::positive},
    {"touch_force", "F_t", "N", Gain::positive},
    {"push_force", "F_p", "N", Gain::positive},
    {"turn_moment", "M_t", "N m", Gain::positive},
    {"hold_time", "t_h", "s", Gain::positive},
    {"lift", "l", "m", Gain::positive},
    {"tilt", "theta", "rad", Gain::positive},
    {"yield", "A", "m/(s N)", Gain::not_negative},
    {"near_entrance", "d_e", "m", Gain::not_negative},
    {"fibre_radius", "r", "m", Gain::positive},
    {"bore_radius", "R", "m", Gain::positive},
    {"mouth_radius", "R_m", "m", Gain::positive},
    {"lead_in_length", "l_m", "m", Gain::not_negative},
});
// The last ones are sizes of the parts, not choices.
inline constexpr std::size_t kSearchSizes = 4;

class SearchLaw : public Controller {
 public:
  enum class Phase { approach, touch, release, lift, move, lower, insert, straighten };

  // One number per gain of the table.
  explicit SearchLaw(std::span<const double> gains) noexcept;

  HandTwist command(const Observation& observation) noexcept override;
  Phase phase() const noexcept { return phase_; }

 private:
  struct Numbers {
    double approach_speed, touch_speed, insert_speed, tilt_rate, touch_force, push_force,
        turn_moment, hold_time, lift, tilt, yield, near_entrance, fibre_radius, bore_radius,
        mouth_radius, lead_in_length;
  };

  // What it does in each phase.
  HandTwist approach(const Observation& o) noexcept;
  HandTwist touch(const Observation& o);
  HandTwist release(const Observation& o) noexcept;
  HandTwist lift(const Observation& o) noexcept;
  HandTwist move(const Observation& o) noexcept;
  HandTwist lower(const Observation& o) noexcept;
  HandTwist insert(const Observation& o) noexcept;
  HandTwist straighten(const Observation& o) noexcept;

  HandTwist begin(Phase phase, const Observation& o) noexcept;
  HandTwist tilted_to(const Eigen::Vector2d& tilt, const Observation& o) const noexcept;
  double felt_force() const noexcept;

  Numbers n_;
  TouchSearch search_;
  Phase phase_ = Phase::approach;
  double since_ = 0, from_ = 0;  // its begin: time [s] and x of the hand [m]

  HandWrench tare_ = HandWrench::Zero();    // mean of what was read in free air
  double noise_ = 0;                        // mean square of the axial force there [N^2]
  int free_ = 0;                            // readings there
  HandWrench smooth_ = HandWrench::Zero();  // of the last readings, less the tare

  double sum_ = 0;                       // of the axial force at rest [N]
  int read_ = 0;                         // readings of it
  double stiffness_ = 0;                 // k [N/m]; 0: not known yet
  double rest_at_ = 0, rest_force_ = 0;  // of the first touch: x of the hand [m], f [N]

  std::size_t probe_ = 0;             // of six: about each axis one way, the other way, the middle
  std::array<double, 2> resisted_{};  // at which tilts [rad]
  Eigen::Vector2d straight_ = Eigen::Vector2d::Zero();  // the tilt to insert with [rad]
};

}  // namespace ferrule
