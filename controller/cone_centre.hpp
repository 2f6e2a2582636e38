// Where a fibre's end moves sideways to find the axis of a cone that it is in, without touching it
// from above: the cone of a lead-in resists where the end reaches it.
//
// Upright and at one height the end can be off the axis by the play p, from there on it touches the
// cone. Twice:
//   roughly   along y and then along z until it touches. Both places are on the circle of radius p
//             about the axis, which is to the left of the way between them, as the corner of the
//             end's way is. p is taken from where the cone is believed to be.
//   finely    near the axis, lower: both ways along y, the middle of which is the axis there, and
//             half of which is p; one way along z, and back by p.
//
// All in one world, the hand's or the tip's. Places are of the hand, (y, z).
#pragma once

#include <Eigen/Core>

namespace ferrule {

struct SidewaysMove {
  bool until_felt;     // in the direction `to`; or to the place `to`
  Eigen::Vector2d to;  // [-] or [m]
};

class ConeCentre {
 public:
  ConeCentre() = default;
  // With the play p > 0 taken to be this [m].
  static ConeCentre roughly(double play) noexcept { return ConeCentre(false, play); }
  static ConeCentre finely() noexcept { return ConeCentre(true, 0); }

  const SidewaysMove& next() const noexcept { return next_; }
  bool ended() const noexcept { return step_ == last(); }
  // It touched, or is there, at this place [m].
  void arrived(const Eigen::Vector2d& place) noexcept;

  double play() const noexcept { return play_; }  // p [m]
  // Where it touched last [m].
  const Eigen::Vector2d& touched() const noexcept { return touched_; }

 private:
  ConeCentre(bool fine, double play) noexcept : fine_(fine), play_(play) {}
  int last() const noexcept { return fine_ ? 5 : 4; }

  bool fine_ = false;
  double play_ = 0;
  int step_ = 0;
  Eigen::Vector2d first_ = Eigen::Vector2d::Zero(), touched_ = first_;
  SidewaysMove next_{true, Eigen::Vector2d::UnitX()};
};

// Centre of the circle of that radius through two places, to the left of who goes from the first to
// the second; midway where they are further apart than its diameter.
Eigen::Vector2d centre_of_circle(const Eigen::Vector2d& first, const Eigen::Vector2d& second,
                                 double radius) noexcept;

}  // namespace ferrule
