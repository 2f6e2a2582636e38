#include "sim/model/breakdown.hpp"

#include "sim/model/world.hpp"

namespace ferrule {

Wrench Breakdown::sum(const Pose& tip) const noexcept {
  Wrench total = Wrench::Zero();
  for (const TermForces& term : terms)
    for (const PointForce& f : term) total += f.wrench(tip);
  return total;
}

Vector3d holder_force(const World& world, const Wrench& holder) noexcept {
  return (holder - world.holder.weight).head<3>();
}

}  // namespace ferrule
