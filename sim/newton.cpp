#include "sim/newton.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace ferrule {

PoseVector newton_direction(const World& world, const Energy& here) noexcept {
  Eliminated hessian;
  if (hessian.of(here.hessian)) {
    PoseVector newton = hessian.solve(here.gradient);
    const double slope = newton.dot(here.gradient);
    if (slope < 0 && std::isfinite(slope)) return newton;
  }
  const Pose gradient = here.gradient.full();
  const Pose unit = world.holder.stiffness.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix5 scaled = unit.asDiagonal() * here.hessian.full() * unit.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix5> modes(scaled);
  if (modes.info() == Eigen::Success) {
    const Pose stiffness = modes.eigenvalues().cwiseAbs().cwiseMax(1e-3);
    const Pose along = modes.eigenvectors().transpose() * unit.cwiseProduct(gradient);
    const Pose direction =
        -unit.cwiseProduct(modes.eigenvectors() * along.cwiseQuotient(stiffness));
    if (direction.allFinite() && direction.dot(gradient) < 0) return PoseVector(direction);
  }
  return PoseVector(-gradient.cwiseQuotient(world.holder.stiffness.diagonal()));
}

}  // namespace ferrule
