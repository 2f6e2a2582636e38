#include "sim/breakdown.hpp"

namespace ferrule {

Wrench Breakdown::sum(const Pose& tip) const noexcept {
  Wrench total = van_der_waals.wrench(tip) + electrostatic.wrench(tip) + gravity.wrench(tip) +
                 capillary.wrench(tip) + meniscus.wrench(tip) + drag[0].wrench(tip) +
                 drag[1].wrench(tip);
  for (int place = 0; place < kContactPlaces; ++place)
    total += adhesion[place].wrench(tip) + wall[place].wrench(tip) + friction[place].wrench(tip);
  return total;
}

Vector3d Breakdown::contact() const noexcept {
  return adhesion[kEnd].force + adhesion[kSide].force + friction[kEnd].force +
         friction[kSide].force;
}

std::array<Vector3d, kTerms> term_forces(const Breakdown& b) noexcept {
  const auto both = [](const std::array<PointForce, kContactPlaces>& f) -> Vector3d {
    return f[kEnd].force + f[kSide].force;
  };
  return {b.van_der_waals.force, b.electrostatic.force,
          b.gravity.force,       b.capillary.force,
          both(b.adhesion),      both(b.wall),
          both(b.friction),      b.drag[0].force + b.drag[1].force,
          b.meniscus.force};
}

}  // namespace ferrule
