#include "sim/terms/potential.hpp"

#include <tuple>

#include "sim/terms/contact.hpp"
#include "sim/terms/friction.hpp"
#include "sim/terms/holder_and_inertia.hpp"
#include "sim/terms/liquid.hpp"
#include "sim/terms/particle.hpp"
#include "sim/terms/surface.hpp"

namespace ferrule {
namespace {

// The list of terms. Of the bore: what does not depend on the step itself.
constexpr std::tuple<SurfaceForcesTerm, MeniscusTerm, ContactTerm, ParticleTerm> kBoreTerms;
// Of the step: smooth ones, and friction.
constexpr std::tuple<HolderTerm, DragTerm, FlowTerm> kStepTerms;

template <class Terms, class... Arguments>
void add_all(const Terms& terms, Arguments&... arguments) noexcept {
  std::apply([&](const auto&... term) { (term.add(arguments...), ...); }, terms);
}
template <class Terms, class... Arguments>
void report_all(const Terms& terms, Arguments&... arguments) noexcept {
  std::apply([&](const auto&... term) { (term.report(arguments...), ...); }, terms);
}

}  // namespace

Potential::Potential(const World& world, const FrozenCoefficients& frozen,
                     const PoseVector& tip) noexcept
    : depth(contact_depths(world, frozen.contact, tip)),
      push{push_at(world, depth[kEnd].value), push_at(world, depth[kSide].value)},
      pull{pull_at(world, depth[kEnd].value, frozen.branch[kEnd]),
           pull_at(world, depth[kSide].value, frozen.branch[kSide])} {
  if (frozen.adhesion_share != 1)
    for (AdhesionForce& shared : pull) {
      shared.potential *= frozen.adhesion_share;
      shared.force *= frozen.adhesion_share;
      shared.slope *= frozen.adhesion_share;
    }
  cut_patch(world, frozen, tip, *this);
  add_all(kBoreTerms, world, frozen, tip, *this);
  static_cast<Energy&>(*this) = bore;
  Energy& total = *this;
  add_all(kStepTerms, world, frozen, tip, total);
  FrictionTerm::add(world, frozen, tip, total);
}

void Potential::follow(const PoseVector& move, const PoseVector& tip) noexcept {
  bore.gradient += bore.hessian.times(move);
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    if (depth[at].value == -INFINITY) continue;
    const double deeper = depth[at].by_pose(tip.t).dot(move);
    depth[at].value += deeper;
    push[at].force += push[at].slope * deeper;
    pull[at].force += pull[at].slope * deeper;
    pull[at].radius += pull[at].radius_slope * deeper;
  }
}

Energy without_friction(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                        const PoseVector& bore_gradient, const PoseMatrix& bore_hessian) noexcept {
  Energy total;
  total.gradient = bore_gradient;
  total.hessian = bore_hessian;
  add_all(kStepTerms, world, frozen, tip, total);
  return total;
}

void forces(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
            const Potential& there, Breakdown& b) noexcept {
  report_all(kBoreTerms, world, frozen, tip, there, b);
  report_all(kStepTerms, world, frozen, tip, there, b);
  FrictionTerm::report(world, frozen, tip, there, b);
}

}  // namespace ferrule
