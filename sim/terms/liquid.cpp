#include "sim/terms/liquid.hpp"

#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

// Drag along x over the step (FrozenCoefficients::axial_drag).
AxialForce axial_drag(const FrozenCoefficients& frozen, const PoseVector& tip) noexcept {
  const double before = std::max(0.0, -frozen.from.x), now = std::max(0.0, -tip.x);
  const double k = frozen.axial_drag, more = now - before;
  return {k * more * more * (now + 2 * before) / 6, 0.5 * k * more * (now + before), k * now};
}

// Of the fluid ahead of the end, over the step.
AxialForce flow_ahead(const FrozenCoefficients& frozen, const PoseVector& tip) noexcept {
  return tip.x < 0 ? frozen.flow.at(-tip.x) : AxialForce{};
}

void add_axial(Energy& total, const AxialForce& axial) noexcept {
  total.value += axial.energy;
  total.value_scale += std::abs(axial.energy);
  total.force_scale += std::abs(axial.force);
  total.gradient.x -= axial.force;
  total.hessian.xx += axial.stiffness;
}

bool meniscus_acts(const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept {
  return world.laws.meniscus && frozen.contact.side == EdgeSide::throat && tip.x < 0;
}

}  // namespace

void MeniscusTerm::add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                       Potential& potential) noexcept {
  if (!meniscus_acts(world, frozen, tip)) return;
  Energy& bore = potential.bore;
  const double inwards = meniscus(*world.laws.meniscus, world.annulus.fibre_radius);
  bore.value += inwards * tip.x;
  bore.value_scale -= inwards * tip.x;
  bore.gradient.x += inwards;
  bore.force_scale += inwards;
}

void MeniscusTerm::report(const World& world, const FrozenCoefficients& frozen,
                          const PoseVector& tip, const Potential&, Breakdown& b) noexcept {
  if (meniscus_acts(world, frozen, tip))
    b[Term::meniscus][0] = {{-meniscus(*world.laws.meniscus, world.annulus.fibre_radius), 0, 0},
                            tip.position()};
}

void DragTerm::add(const World&, const FrozenCoefficients& frozen, const PoseVector& tip,
                   Energy& total) noexcept {
  if (frozen.axial_drag > 0) add_axial(total, axial_drag(frozen, tip));
}

void DragTerm::report(const World&, const FrozenCoefficients& frozen, const PoseVector& tip,
                      const Potential&, Breakdown& b) noexcept {
  if (!(frozen.axial_drag > 0)) return;
  const double axial = 0.5 * axial_drag(frozen, tip).force;
  const PoseVector moved = tip - frozen.from;
  for (std::size_t i = 0; i < 2; ++i) {
    const double arm = frozen.drag_arm[i];
    const Vector2d e = eccentricity(tip, arm);
    const Vector2d sideways = -(frozen.drag_per_move * (moved.e + arm * moved.t));
    b[Term::drag][i] = {{axial, sideways.x(), sideways.y()}, {tip.x + arm, e.x(), e.y()}};
  }
}

void FlowTerm::add(const World&, const FrozenCoefficients& frozen, const PoseVector& tip,
                   Energy& total) noexcept {
  if (frozen.flow.acts()) add_axial(total, flow_ahead(frozen, tip));
}

void FlowTerm::report(const World&, const FrozenCoefficients& frozen, const PoseVector& tip,
                      const Potential&, Breakdown& b) noexcept {
  if (frozen.flow.acts())
    b[Term::flow][0] = {{flow_ahead(frozen, tip).force, 0, 0}, tip.position()};
}

}  // namespace ferrule
