// The energy along a Newton step whose stiff laws are as they are, and not as its model has them:
// depths cost little to compute, so a step is cut to where they say that it ends.
#pragma once

#include "sim/newton.hpp"

namespace ferrule {

using StiffLaws = std::array<StiffLaw, kStiffLaws>;

inline constexpr double kLevel = 1e-9;  // of the sum of all energies: they round to that

// After a part of the step.
struct AlongStep {
  double energy;    // what it has changed by [J]
  double slope;     // by the part [J]
  double rounding;  // of the energy [J]
};

// Of the step `newton` from `tip`, where the stiff laws are `here`; refers to all of them.
class StiffModel {
 public:
  StiffModel(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
             const StiffLaws& here, const NewtonStep& newton) noexcept;

  StiffLaws laws(double part) const noexcept;
  AlongStep at(double part, const StiffLaws& there) const noexcept;
  // Is it higher there than where the step begins?
  bool higher(const AlongStep& there) const noexcept { return there.energy > there.rounding; }

  // The part, up to `most`, at which the energy is least before it rises.
  double least(double most) const noexcept;
  // The part, up to `most`, at which a contact that the step opens, and that adhesion holds, pulls
  // most: what is beyond may be lower and yet not reached, as it holds while another one opens.
  // Not looked for among printed laws, which take much longer to evaluate.
  double strongest_pull(double most) const noexcept;

 private:
  double barrier(double most) const noexcept;

  const World& world_;
  const FrozenCoefficients& frozen_;
  const PoseVector& tip_;
  const StiffLaws& here_;
  const NewtonStep& newton_;
  double slope_ = 0, curve_ = 0;
  double deeper_ = 0;  // the stiff laws are, or less deep, after the whole move [m]
};

}  // namespace ferrule
