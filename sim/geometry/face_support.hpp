// Where a fibre's end rests on the ferrule's front face.
//
// The end's disc, of radius r, lies over the opening's, of radius R, its centre e aside: what is
// supported is the crescent outside the opening. A flat end that is tilted against the face is
// lowest, over the crescent, at the rim's lowest point if that lies outside the opening, else at
// one of the two points where the circles meet, at phi from the direction of e,
//   cos phi = (R^2 - r^2 - e^2)/(2 r e),
// or on both of them; never on the opening's edge between. These are the extreme points of the
// segment of the end's disc with p.n >= r cos phi, n = e/|e|, so it lies h ahead of the end's
// centre,
//   h(slope) = max over the segment of p.slope,
// at the p where that is. An end parallel to the face touches it everywhere: the resultant is in
// the crescent's centroid p_c. A real contact goes over from one to the other within the tilt that
// closes the elastic dent, some nm over the radius; here within kRestTilt, by
//   h = max over the segment of p.slope - kRestTilt |p - p_c|^2/(2 r),
// which has the derivative p: the segment's nearest point to p_c + r slope/kRestTilt.
#pragma once

#include "sim/geometry/pose.hpp"

namespace ferrule {

inline constexpr double kRestTilt = 1e-5;  // [rad]

class FaceSupport {
 public:
  FaceSupport() = default;  // none
  // Radius of the end's disc and of the opening [m], the disc's centre from the opening's [m].
  FaceSupport(double radius, double opening, const Vector2d& e) noexcept;

  bool any() const noexcept { return radius_ > 0; }

  // Where it is lowest for a slope of the face against the ferrule's [rad]: the point that rests is
  // `ahead` of the end's centre, into the ferrule.
  struct Rest {
    double ahead;      // h [m]
    Vector2d point;    // p = dh/dslope, from the end's centre [m]
    Vector2d by_e;     // dh/de [-]
    Matrix2d turning;  // dp/dslope [m]
  };
  Rest rest(const Vector2d& slope) const noexcept;

 private:
  double radius_ = 0, least_ = 0;         // r; p.n at least [m]
  Vector2d outward_ = Vector2d::UnitX();  // n
  double centroid_ = 0;                   // along n [m]
  double off_ = 0;                        // |e| [m]
  double least_by_off_ = 0, centroid_by_off_ = 0;
};

}  // namespace ferrule
