// Breaking the contact (III.E of the paper): what a hand must pull with to part a fibre that lies
// along the bore's wall, over the paths that a hand can take.
//
//   lift    straight off the wall, parallel: every place of contact and the whole length at once.
//           At the separation s the pull is
//             sum of the places' adhesion(-s) + surface forces at the gap s + weight
//           and what it takes is the largest pull on the way.
//   peel    lifted at the bore's mouth, turning about the fibre's end. About the end, with s the
//           separation at the mouth, it takes
//             adhesion(-s) + integral from 0 to 1 of u f(u s) du + weight,  f = length times the
//           force per length at a gap; printed laws know one gap, s/2, where they act. Then the end
//           is lifted alone, which takes its adhesion: the larger of both counts.
//   slide   out of the bore along the wall: friction of every place at the contact radius that the
//           attraction of the surfaces presses it to, meniscus, and drag at a speed.
//
// The weight, as much of it as the holder leaves to the end (Holder::weight: all of a rigid hand's,
// half of an elastic fibre's), counts against the hand: the wall is the one below. In equilibrium
// nothing else presses the fibre to the wall. A soft hand pulls with the force, not the way: it
// lets go at the largest pull. Closed forms: the pull-off force of one place lies between that of
// JKR, 3/2 pi w R_s, and that of DMT, 2 pi w R_s (sim/laws/maugis.hpp has it for any lambda);
// surface forces, weight, friction and meniscus are those of their laws.
#pragma once

#include <array>
#include <vector>

#include "sim/model/world.hpp"

namespace ferrule {

enum class ReleasePath { lift, peel, slide };
inline constexpr std::array<const char*, 3> kReleasePaths = {"lift", "peel", "slide"};

struct Release {
  ReleasePath path;
  double force;                      // it takes [N], >= 0; 0: nothing holds
  double separation;                 // at which [m]; 0 of slide
  std::array<double, kTerms> terms;  // what each holds there [N], > 0 against the hand
};

// A fibre that touches at `places` (1: its end, or its side at the mouth; 2: both), `length` [m]
// inserted, >= 0; drag at `speed` [m/s], >= 0. The paper's printed contact is shared by its places.
std::vector<Release> release(const World& world, double length, int places, double speed);

// Radius of a contact [m] that is pressed together by `load` [N], >= 0, and by its own adhesion; 0
// where the world has no contact law.
double loaded_radius(const World& world, double load) noexcept;

}  // namespace ferrule
