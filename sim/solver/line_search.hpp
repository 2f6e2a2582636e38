// The line search among nonsmooth terms: the energy along a Newton step with these terms as they
// are, and not as the local model has them. Depths cost little to compute, so a step is cut to
// where they say that the energy is least, before the potential is evaluated.
#pragma once

#include "sim/solver/local_model.hpp"
#include "sim/terms/nonsmooth.hpp"

namespace ferrule {

using NonsmoothTerms = std::array<NonsmoothTerm, kNonsmoothTerms>;

// After a part of the step.
struct MeritValue {
  double energy;    // what it has changed by [J]
  double slope;     // by the part [J]
  double rounding;  // of the energy [J]
};

// Of the step `newton` from `tip`, where the nonsmooth terms are `start`; refers to all of them.
class MeritModel {
 public:
  MeritModel(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
             const NonsmoothTerms& start, const NewtonStep& newton) noexcept;

  NonsmoothTerms terms(double part) const noexcept;
  MeritValue at(double part, const NonsmoothTerms& terms) const noexcept;
  // Is it higher there than where the step begins?
  bool higher(const MeritValue& value) const noexcept { return value.energy > value.rounding; }

  // The part at which the energy is least before it rises.
  double least() const noexcept;
  // The part, up to `most`, at which a contact that the step opens, and that adhesion holds, pulls
  // most: what is beyond may be lower and is yet not to be had, as it holds while another one
  // opens.
  double largest_adhesion(double most) const noexcept;

 private:
  double first_barrier() const noexcept;

  const World& world_;
  const FrozenCoefficients& frozen_;
  const PoseVector& tip_;
  const NonsmoothTerms& start_;
  const NewtonStep& newton_;
  double slope_ = 0, curve_ = 0;
  double deepening_ = 0;  // by how much the depths change over the whole move, at most [m]
};

}  // namespace ferrule
