// Where a fibre's end touches next, while it looks for the bore.
//
// It comes down upright. If it comes to rest, it touches there again, tilted to several sides:
//   on the front face   8 sides the first time and 4 afterwards. All touches together locate the
//                       opening and its clearance (controller/locate_opening.hpp). Where the end's
//                       own slope turned out to be a good part of the tilt, so that it rests on one
//                       side however it is tilted, 4 more sides about that slope, further apart.
//   on an edge          the cone of a lead-in, or the bore's edge where the end is in it already.
//                       There 3 sides tell which one is caught: the one that a tilt lifts. It goes
//                       the other way, by what an end that touches the opening's edge at this
//                       height is off its axis; by half of the last step where it had come from
//                       there.
// Then it comes down upright at the axis. It is on an edge where the ferrule has turned out to have
// a cone, by the height of a touch or by how much lower than another it came; or where the end
// rests lower than the face lets it; or where no opening explains the touches, but only twice in a
// row.
//
// A rounded rim rests on the face with a smaller disc, as if the clearance were larger.
//
// All in one world, the hand's or the tip's. x, across and tilts are of the hand since the start.
#pragma once

#include <vector>

#include "controller/locate_opening.hpp"

namespace ferrule {

struct TouchNumbers {
  double fibre_radius;    // r [m]
  double bore_radius;     // R [m], > r
  double mouth_radius;    // of the lead-in at the front face [m], >= R
  double lead_in_length;  // [m]; 0: none
  double near;            // up to which the entrance's place may be wrong [m], >= 0
  double tilt;            // theta [rad]
  double lift;            // what counts as another height [m]
};

struct TouchPlace {
  Eigen::Vector2d across = Eigen::Vector2d::Zero();  // [m]
  Eigen::Vector2d tilt = Eigen::Vector2d::Zero();    // [rad]
};

inline constexpr double kHeightError = 1e-4;  // of a touch, of r: 6 nm

class TouchSearch {
 public:
  explicit TouchSearch(const TouchNumbers& numbers) noexcept : n_(numbers) {}

  // The end has come to rest; `height` of the hand before where the entrance is taken to be [m],
  // < 0 past it.
  void rested(const Touch& touch, double height);
  // It is upright again, without having come to rest.
  void straightened() noexcept { sides_ = 0; }

  // The ferrule has turned out to have a cone.
  void recognise_cone() noexcept { has_cone_ = true; }

  bool begun() const noexcept { return begun_; }
  // The next place; at first the start.
  const TouchPlace& next() const noexcept { return next_; }
  // Between which x it would rest there, on the face or on the edge that it is on [m].
  double highest_rest() const noexcept { return level() + reach(); }
  double lowest_rest() const noexcept { return level() - reach(); }
  // By how much an upright end can be off the axis at a height within the lead-in, or at its ends
  // beyond them, and the height at which that is so [m].
  double play(double height) const noexcept;
  double height_of(double play) const noexcept;
  // How much higher still, should it be further away from the axis of a cone there [m].
  double climb() const noexcept {
    if (!(has_cone_ && on_edge_ && upright())) return 0;
    return step_ * n_.lead_in_length / (n_.mouth_radius - n_.bore_radius);
  }

 private:
  bool upright() const noexcept { return sides_ == 0; }
  double level() const noexcept { return on_edge_ ? edge_ : opening_.face; }
  double reach() const noexcept { return n_.fibre_radius * (opening_.slope + next_.tilt).norm(); }
  double clearance() const noexcept { return n_.bore_radius - n_.fibre_radius; }
  // Of an end at the opening's edge from inside, at the last upright touch.
  double off_axis() const noexcept { return play(height_); }
  void recognise(double x, double height);
  void first_sides();
  void further_sides();
  void locate();
  void leave_edge();

  TouchNumbers n_;
  std::vector<Touch> touches_;
  Opening opening_;
  TouchPlace next_;
  bool begun_ = false, located_ = false;
  double height_ = 0;   // of the last upright touch [m]
  double rested_ = 0;   // x of the last touch [m]
  double highest_ = 0;  // and of the highest [m]

  std::size_t first_ = 0;             // the upright one of the touches here
  std::size_t side_ = 0, sides_ = 0;  // the next one; 0 of 0: upright
  Eigen::Vector2d here_ = Eigen::Vector2d::Zero(), centre_ = Eigen::Vector2d::Zero();
  double apart_ = 0;  // of the sides from their centre [rad]

  bool has_cone_ = false, on_edge_ = false, unexplained_ = false;
  int edges_ = 0;                                     // in a row
  double edge_ = 0;                                   // x of the last upright touch on one [m]
  double step_ = 0;                                   // the last away from one [m]
  Eigen::Vector2d caught_ = Eigen::Vector2d::Zero();  // and where it had been
};

}  // namespace ferrule
