#include "sim/breakdown.hpp"

namespace ferrule {

Wrench Breakdown::sum(const Pose& tip) const noexcept {
  Wrench total = gravity.wrench(tip) + meniscus.wrench(tip);
  for (const auto& pair : {van_der_waals, electrostatic, capillary, drag, adhesion, wall, friction})
    for (const PointForce& f : pair) total += f.wrench(tip);
  return total;
}

Vector3d Breakdown::contact() const noexcept {
  return adhesion[kEnd].force + adhesion[kSide].force + friction[kEnd].force +
         friction[kSide].force;
}

std::array<Vector3d, kTerms> term_forces(const Breakdown& b) noexcept {
  const auto both = [](const std::array<PointForce, 2>& f) -> Vector3d {
    return f[0].force + f[1].force;
  };
  return {both(b.van_der_waals), both(b.electrostatic), b.gravity.force,
          both(b.capillary),     both(b.adhesion),      both(b.wall),
          both(b.friction),      both(b.drag),          b.meniscus.force};
}

Vector3d holder_force(const World& world, const Breakdown& breakdown) noexcept {
  return (breakdown.holder - world.holder.weight).head<3>();
}

}  // namespace ferrule
