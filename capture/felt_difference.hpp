// Could a hand tell two recordings apart by what it felt?
//
// The recordings are compared where the holder was at the same place along x, in stretches of a
// micrometre. In each, what is felt is the mean of the holder's force relative to that of the first
// row, at rest, in the hand's world: F_a and F_b. They are told apart where
//   |F_a - F_b| >= max(kNoticedForce, kNoticedShare max(|F_a|, |F_b|)),
// a just noticeable difference (capture/force_history.hpp).
#pragma once

#include "capture/force_history.hpp"

namespace ferrule {

// Of some of the stretches.
struct FeltApart {
  std::size_t stretches = 0;
  double noticed = 0;  // share of them where the two are told apart [-]; NaN: there is none
  double median = 0, largest = 0;  // of |F_a - F_b| [N]; 0: none
};

// One touches a stretch that touches in half of its rows. Where one touches and the other does not,
// they differ by where the hands went, too: so do two recordings of one scene.
struct FeltDifference {
  FeltApart all, either_touches, both_touch;
};

// Of two episodes recorded in `scene_a` and `scene_b`, one row at least each.
FeltDifference felt_difference(const Episode& a, const Scene& scene_a, const Episode& b,
                               const Scene& scene_b);

}  // namespace ferrule
