// Where the corrected surface laws (1c), (2c) end: at contact of the mean planes.
//
// They act across the gap h + roughness. For h < 0 the solids are deformed and their mean planes
// stay at the roughness: the force is held at its value for h = 0. Smooth surfaces (roughness below
// the interatomic distance) are held from where the gap is that distance. Force and potential are
// continuous.
#pragma once

#include <algorithm>

#include "sim/annulus.hpp"
#include "sim/printed_range.hpp"

namespace ferrule::corrected {

// `law(h)` is the bare formula, valid where h + roughness > 0.
template <class Law>
LineForce held_in_contact(const Law& law, const Annulus& annulus, double h) noexcept {
  const double closest = std::max(0.0, printed::kInteratomicDistance - annulus.roughness);
  if (h >= closest) return law(h);
  const LineForce end = law(closest);
  return {end.potential - end.force * (h - closest), end.force, 0};
}

}  // namespace ferrule::corrected
