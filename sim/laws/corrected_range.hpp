// Where the corrected surface laws (1c), (2c) end: at contact.
//
// They act across the gap h + roughness down to h = 0; those of smooth surfaces (roughness below
// the interatomic distance) down to where the gap is that distance. Closer than that the
// asperities (or the atoms) take over: what they carry is not known in detail, but it grows within
// a distance t of the order of the roughness. The net force per length falls linearly,
//   f(h) = f(h_c) (1 - (h_c - h)/t),   t = max(roughness, interatomic distance),
// to nothing where the mean planes meet, and pushes beyond. Without that a law of many newtons per
// metre would press the fibre ever deeper into a wall that only resists at its two points of
// contact. Force and potential are continuous.
#pragma once

#include <algorithm>

#include "sim/geometry/annulus.hpp"

namespace ferrule::corrected {

// t above [m].
inline double asperity_range(const Annulus& annulus) noexcept {
  return std::max(annulus.roughness, kInteratomicDistance);
}

// `law(h)` is the bare formula, valid for h >= closest.
template <class Law>
LineForce down_to(double closest, const Law& law, const Annulus& annulus, double h) noexcept {
  if (h >= closest) return law(h);
  const LineForce end = law(closest);
  const double t = asperity_range(annulus), over = closest - h;
  return {end.potential + end.force * over * (1 - 0.5 * over / t), end.force * (1 - over / t),
          end.force / t};
}

// The same for a law across the gap h + roughness.
template <class Law>
LineForce down_to_contact(const Law& law, const Annulus& annulus, double h) noexcept {
  return down_to(asperity_range(annulus) - annulus.roughness, law, annulus, h);
}

}  // namespace ferrule::corrected
