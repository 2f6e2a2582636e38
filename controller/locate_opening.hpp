// Where the bore opens, by touch: from the heights at which a fibre's end, tilted this way and
// that, comes to rest on the ferrule's front face.
//
// The end's disc, of radius r, rests on the crescent outside the opening, of radius R
// (sim/geometry/face_support.hpp). With the hand displaced by x along the axis, by u sideways, and
// tilted by t, it rests where
//   x = x_f + h(s + t; u - a),   h(s; e) = max of p.s over the crescent's convex hull at offset e,
// with x_f the height of the face, s the slope of the untilted end against it, and a the opening's
// axis. These five numbers and the clearance c = R - r, of which c_0 is the nominal one, minimise
//   sum over the touches of ((x - x_f - h)/sigma)^2
//     + |a|^2/a_0^2 + |s|^2/s_0^2 + (log(c/c_0)/v_0)^2
// (Levenberg and Marquardt, from several first guesses of a). The point of the opening's edge that
// carries the end moves with R as with a shift of a along its radius: dh/dR = dh/da.(p - a)/R.
// A disc that touches the opening's edge from inside, at e = R - r, is the limit in which the
// crescent is a point: h = (s + t).r e/|e|.
//
// All in one world, the hand's or the tip's.
#pragma once

#include <Eigen/Core>
#include <span>

namespace ferrule {

struct Touch {
  double x;                // of the hand where the end rests [m]
  Eigen::Vector2d across;  // u [m]
  Eigen::Vector2d tilt;    // t [rad]
};

struct Discs {
  double fibre, opening;  // r, and R by its nominal size [m]; 0 < r < R
};

struct TouchErrors {
  double height;           // sigma, standard deviation of x [m], > 0
  double far;              // a_0 [m], > 0
  double slope = 0.02;     // s_0 [rad], > 0
  double clearance = 0.7;  // v_0, of its logarithm [-], > 0
};

struct Opening {
  Eigen::Vector2d axis = Eigen::Vector2d::Zero();   // a [m]
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();  // s [rad]
  double face = 0;                                  // x_f [m]
  double misfit = 0;                                // root mean square of x - x_f - h [m], >= 0
  double clearance = 0;                             // c [m], > 0
};

// h [m] at a slope [rad] and an offset e of the disc's centre from the opening's [m]. A disc that
// lies within the opening counts as one that touches its edge on that side.
double rest_height(const Discs& discs, const Eigen::Vector2d& slope,
                   const Eigen::Vector2d& e) noexcept;

// From one touch at least; five and more determine all of it but c, for which it takes touches at
// several places.
Opening locate_opening(std::span<const Touch> touches, const Discs& discs,
                       const TouchErrors& errors);

}  // namespace ferrule
