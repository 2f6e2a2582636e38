// An insertion that finds the bore by touch, without learning. It needs the axial force, tilt as an
// action, and its own motion remembered; no moments before it is in the bore.
//
//   approach     rests for t_h, then goes straight in, slower near where the entrance is taken to
//                be, until it is felt: an axial force above F_t, or above what the sensor's noise
//                in free air ever reaches
//   touch        rests for t_h, longer where the sensor is noisy, and takes the mean axial force f;
//                the end is at x = x_hand + f/k. The first time it gives way (release) until less
//                than half of f is left, and rests again: that gives the stiffness k. An end that
//                is pushed aside lies on a slope and goes on to insert.
//   lift         off by l, gently at first, further where something still holds it, or on into the
//                bore where that holds it too well; move to the next place (touch search); lower:
//                fast where nothing can be in the way, then at the touching speed. An end that comes
//                lower than the face lets it is in the opening.
//   insert       v_x = -v_i (1 - |f|^2/F_p^2), not backwards and of f_x only what presses,
//                v_y = A f_y, v_z = A f_z, upright. Held up at the face it touches there; held up
//                in the bore:
//   back off     by l at least, until nothing presses; straighten: tilts to one side and to the
//                other until the bore resists with a moment M_t, about each axis, and inserts on in
//                the middle, with F_p larger by 15 %, and by 35 % at most. A tilt moves the
//                fibre's side along the wall, by r for a radian; it gives way along the bore to
//                what that adds.
//
// A holder that moves later than it is told to, or by another amount, shows that in free air: after
// T, on its way at one speed that has become g v where v was meant, it has moved by g v (T - d).
// From then on it is told to move by 1/g of what is meant. With a delay or a lag d > 0 speeds are
// such that what it goes on by after a touch, v d, brings the force to F_p at most (k is taken
// as 1 mN/um, as the touching speed assumes, until it is known; who knows k at first approaches so,
// too); and it keeps away from a cone until it is near the axis:
//   centre       half way down the lead-in, and again near its end, it moves sideways until the cone
//                resists (cone centre). How far it could move there tells how high the cone is.
//
// Forces are relative to their mean in free air. Lengths and speeds are of the hand.
#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "controller/cone_centre.hpp"
#include "controller/controller.hpp"
#include "controller/gain.hpp"
#include "controller/hand_response.hpp"
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

// What somebody knows of his own hand, and others find out.
struct KnownHand {
  double lag = 0;        // from what is felt to what the holder does [s]; 0: is measured
  double stiffness = 0;  // of the holder along the bore [N/m]; 0: not known before a touch
};

class SearchLaw : public Controller {
 public:
  enum class Phase {
    approach,
    centre,
    touch,
    release,
    lift,
    move,
    lower,
    insert,
    back_off,
    straighten
  };
  static constexpr std::array kPhaseNames = {"approach", "centre",    "touch", "release",
                                             "lift",     "move",      "lower", "insert",
                                             "back_off", "straighten"};

  // With what it inserts once it has straightened again, where it inserted with `push` [N].
  static double harder(double push, double push_force) noexcept {
    return std::min(1.15 * push, 1.35 * push_force);
  }

  // One number per gain of the table.
  explicit SearchLaw(std::span<const double> gains, const KnownHand& hand = {}) noexcept;

  HandTwist command(const Observation& observation) noexcept override;
  const char* phase_name() const noexcept override {
    return kPhaseNames[static_cast<std::size_t>(phase_)];
  }

 private:
  struct Numbers {
    double approach_speed, touch_speed, insert_speed, tilt_rate, touch_force, push_force,
        turn_moment, hold_time, lift, tilt, yield, near_entrance, fibre_radius, bore_radius,
        mouth_radius, lead_in_length;
  };

  HandTwist answer(const Observation& o);
  // What it does in each phase.
  HandTwist approach(const Observation& o) noexcept;
  HandTwist centre(const Observation& o) noexcept;
  HandTwist touch(const Observation& o);
  HandTwist release(const Observation& o) noexcept;
  HandTwist lift(const Observation& o) noexcept;
  HandTwist move(const Observation& o) noexcept;
  HandTwist lower(const Observation& o) noexcept;
  HandTwist insert(const Observation& o) noexcept;
  HandTwist back_off(const Observation& o) noexcept;
  HandTwist straighten(const Observation& o) noexcept;

  HandTwist begin(Phase phase, const Observation& o) noexcept;
  HandTwist tilted_to(const Eigen::Vector2d& tilt, double time,
                      const Observation& o) const noexcept;
  HandTwist sideways_to(const Eigen::Vector2d& place, const Observation& o) const noexcept;
  bool is_at(const Eigen::Vector2d& place, const Observation& o) const noexcept;
  double felt_force() const noexcept;
  double felt_smooth_force() const noexcept;
  double felt_moment() const noexcept;
  bool late() const noexcept;
  bool gives_way() const noexcept;
  bool time_to_centre(const Observation& o) const noexcept;
  void centred(const Observation& o) noexcept;
  double stiffness() const noexcept;
  double stoppable(double speed, double further) const noexcept;
  double touching(double speed) const noexcept;
  double touching() const noexcept;
  double pulling() const noexcept;
  double inserting() const noexcept;
  double goal_time() const noexcept;

  Numbers n_;
  KnownHand known_;
  TouchSearch search_;
  Phase phase_ = Phase::approach;
  double since_ = 0;                  // its begin [s]
  HandPose from_ = HandPose::Zero();  // and the displacement then

  HandWrench tare_ = HandWrench::Zero();   // mean of what was read in free air
  HandWrench noise_ = HandWrench::Zero();  // mean squares of what was read there
  int free_ = 0;                           // readings there
  HandResponse hand_{known_.lag};
  HandWrench smooth_ = HandWrench::Zero();  // of the last readings, less the tare

  double sum_ = 0;                       // of the axial force at rest [N]
  int read_ = 0;                         // readings of it
  double stiffness_ = 0;                 // k [N/m]; 0: not known yet
  double rest_at_ = 0, rest_force_ = 0;  // of the first touch: x of the hand [m], f [N]

  double push_ = n_.push_force;  // with which it inserts [N]
  int to_centre_ = 2;            // how often still; 0 where there is no cone
  ConeCentre centre_;
  bool at_cone_ = false;  // it touches it still
  double held_ = 0;       // how far from there the cone held it [m]
  double entrance_ = 0;   // its height where it was taken to be at 0 [m]
  // Up to which heights before and behind it a touch is to be expected [m].
  double before_ = n_.near_entrance, behind_ = n_.near_entrance;
  bool relaxed_ = false;              // along the bore, before it turns
  std::size_t probe_ = 0;             // of six: about each axis one way, the other way, the middle
  std::array<double, 2> resisted_{};  // at which tilts [rad]
  Eigen::Vector2d straight_ = Eigen::Vector2d::Zero();  // the tilt to insert with [rad]
};

}  // namespace ferrule
