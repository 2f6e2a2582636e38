// The work of a hand, against what it stores: nothing else drives the fibre, so that what is
// missing was dissipated, and is never negative.
#pragma once

#include "sim/model/state.hpp"
#include "sim/model/world.hpp"

namespace ferrule {

// What holder, weight, surface forces and contacts store in a state [J], up to a constant of the
// world. Not what stuck friction, motion and a gas shut in store besides: nothing at rest in free
// air, never less anywhere.
double stored_energy(const World& world, const State& state) noexcept;

class HandWork {
 public:
  explicit HandWork(const World& world, const State& start) noexcept;

  // The hand goes on from the command of `state`, while the fibre holds still; then it gives way.
  void move(const State& state, const Pose& to) noexcept;

  double work() const noexcept { return work_; }      // [J]
  double turned() const noexcept { return turned_; }  // sum of the magnitudes of its parts [J]

  // Has the fibre gained energy by `end`, beyond 1e-9 of what was turned over? An end that is left
  // elsewhere than it began, sucked into the bore or stuck to it, has given some to the hand.
  // `start` is to be at rest, in free air or without friction.
  bool gained(const State& end) const noexcept;

 private:
  const World& world_;
  double stored_, work_ = 0, turned_ = 0;
};

}  // namespace ferrule
