// The ferrule in the plane through its axis, and how deep a point is in it.
//
// Frame: the origin is the centre of the bore's entrance plane, the bore occupies x <= 0, x points
// out of it. In the half plane (x, rho), rho the distance from the axis, the solid is the
// intersection of
//   bore:  rho > R                       (depth rho - R)
//   cone:  rho > R + x tan(beta)         (depth (rho - R) cos(beta) - x sin(beta)), beta half angle
//   face:  x < L                         (depth L - x)
// with L the length of the lead-in, 0 where there is none.
// The bore and the cone together are the throat: its depth is the smaller of the two. Which of face
// and throat a fibre end rests against is decided by where it came from (EdgeSide), so that however
// hard the end is pushed onto the face it does not slip into the bore.
#pragma once

#include <algorithm>
#include <cmath>

namespace ferrule {

struct FerruleProfile {
  double bore_radius;      // R [m], > 0
  double lead_in_length;   // L [m], >= 0; 0: sharp edge
  double lead_in_tangent;  // tan(beta) [-], >= 0
  double length;           // of the bore [m], > 0

  bool has_lead_in() const noexcept { return lead_in_length > 0; }
  // cos(beta) [-].
  double lead_in_cosine() const noexcept {
    return 1 / std::sqrt(1 + lead_in_tangent * lead_in_tangent);
  }
  // Radius of the lead-in where it meets the face [m]; R without a lead-in.
  double mouth_radius() const noexcept { return bore_radius + lead_in_length * lead_in_tangent; }
};

// Signed depths of a point in the solid [m]; it is inside where both are positive.
struct EdgeDepth {
  double face;
  double bore;
  double cone;  // +infinity without a lead-in

  double throat() const noexcept { return std::min(bore, cone); }
  bool inside() const noexcept { return face > 0 && throat() > 0; }
};

// What a fibre end is separated from the solid by.
enum class EdgeSide { throat, face };

inline EdgeDepth edge_depth(const FerruleProfile& profile, double x, double rho) noexcept {
  const double radial = rho - profile.bore_radius;
  double cone = INFINITY;
  if (profile.has_lead_in())
    cone = (radial - x * profile.lead_in_tangent) * profile.lead_in_cosine();
  return {profile.lead_in_length - x, radial, cone};
}

// The side of a point outside the solid: whichever it is farther outside of. A point inside keeps
// the side it entered by, `before`.
inline EdgeSide edge_side(const EdgeDepth& depth, EdgeSide before) noexcept {
  if (depth.inside()) return before;
  return depth.face < depth.throat() ? EdgeSide::face : EdgeSide::throat;
}

}  // namespace ferrule
