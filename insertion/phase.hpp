// How far an insertion is, row by row.
#pragma once

#include <algorithm>
#include <array>
#include <optional>

#include "insertion/watch.hpp"

namespace ferrule {

// In front of the ferrule; touching its face, or the cone of its lead-in; in the bore touching
// nothing, with one place, with both; deep enough; wedged.
enum class Phase { approach, face, cone, in_bore, one_point, two_point, seated, jammed };
inline constexpr std::array kPhases = {"approach",  "face",      "cone",   "in_bore",
                                       "one_point", "two_point", "seated", "jammed"};

// Smallest gap between fibre and bore, at its mouth or at the fibre's end [m]; < 0: they overlap.
// Of an end outside, as if the bore went on to there: < 0 is what it lacks to go in.
inline double smallest_gap(const World& world, const State& state) noexcept {
  const Vector2d end = state.tip.segment<2>(1);
  const Vector2d mouth = end + state.inserted_length() * state.tip.tail<2>();
  return world.annulus.clearance() - std::max(end.norm(), mouth.norm());
}

// How far the hand has to move sideways, along y and z [m], until the fibre, were it bent by its
// weight alone, is in the middle of the bore: halfway between its end and the bore's mouth, or of
// an end outside that end.
inline Vector2d way_to_axis(const World& world, const State& state) noexcept {
  const Pose hangs = state.command + world.holder.sag;
  return -(hangs.segment<2>(1) + 0.5 * state.inserted_length() * hangs.tail<2>());
}

class PhaseWatch {
 public:
  // After each step: with its state, and what InsertionWatch saw. `seated` stays.
  Phase after(const State& state, const std::optional<Outcome>& seen) noexcept {
    if (seen == Outcome::jam) return Phase::jammed;
    seated_ = seated_ || seen == Outcome::inserted;
    if (seated_) return Phase::seated;
    const bool end = state.contact[kEnd].closed, side = state.contact[kSide].closed;
    if (end && state.side == EdgeSide::face) return Phase::face;
    if (end && state.tip[0] > 0) return Phase::cone;
    if (end && side) return Phase::two_point;
    if (end || side) return Phase::one_point;
    return state.tip[0] < 0 ? Phase::in_bore : Phase::approach;
  }

 private:
  bool seated_ = false;
};

}  // namespace ferrule
