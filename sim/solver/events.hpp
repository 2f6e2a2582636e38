// Where on the path to a command something happens: sub-steps are taken up to it and past it, and
// what lies between them is as short as is asked for. All in parts of the path, from 0 to 1.
#pragma once

#include <algorithm>
#include <cmath>

#include "sim/solver/predictor.hpp"

namespace ferrule {

class EventSearch {
 public:
  // `shortest`: a sub-step in which something happens is at most so long.
  explicit EventSearch(double shortest) noexcept : near_(0.5 * shortest) {}

  double done() const noexcept { return done_; }
  // Is it known that something happens before the end of a sub-step that was rejected?
  bool bracketed() const noexcept { return beyond_ <= 1; }

  // Where to end next, within the bracket: just before the event, just past it, or, where it is not
  // known, in the middle.
  double next() const noexcept {
    const double to = event_ > done_ + 2 * near_      ? event_ - near_
                      : event_ + near_ > done_        ? event_ + near_
                      : (beyond_ - done_) > 2 * near_ ? 0.5 * (done_ + beyond_)
                                                      : beyond_;
    return std::min(to, beyond_);
  }
  bool divisible(double to) const noexcept { return to - done_ > 2.02 * near_; }

  // A sub-step from `now` was rejected: something happens before `to`, about at the part `where`
  // of it, or NaN.
  void reject(const World& world, const StepResult& now, double to, double where) noexcept {
    const bool halved =
        !bracketed() || to - done_ < 0.6 * (beyond_ - done_);  // else `where` misleads
    event_ = halved ? done_ + where * (to - done_) : NAN;
    beyond_ = to;
    if (std::isnan(determinant_)) determinant_ = stiffness_determinant(world, now);
  }

  // It was accepted, and ended in `now`.
  void accept(const World& world, const StepResult& now, double to, bool happened) noexcept {
    if (happened || to >= beyond_) {
      beyond_ = INFINITY;
      determinant_ = NAN;
    } else if (bracketed()) {
      const double fold = extrapolated_fold(to, stiffness_determinant(world, now));
      if (!(event_ > to)) event_ = fold;
    }
    done_ = to;
  }

 private:
  // Where the square of the determinant falls to 0, in a straight line; NaN where it does not.
  double extrapolated_fold(double to, double determinant) noexcept {
    const double square = determinant * determinant, before = determinant_ * determinant_;
    const bool falls = determinant_ > determinant && determinant > 0;
    determinant_ = determinant;
    return falls ? to + (to - done_) * square / (before - square) : NAN;
  }

  double near_;
  double done_ = 0, beyond_ = INFINITY;  // something happens between them
  double event_ = NAN;                   // about there, where that is known
  double determinant_ = NAN;  // at done_, from the first time that a sub-step is rejected
};

}  // namespace ferrule
