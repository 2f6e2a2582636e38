#include "sim/terms/printed_well.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace ferrule {
namespace {

// In the middle of the length, in the round bore that an oval one is stretched to.
Vector2d printed_eccentricity(const World& world, double arm, const PoseVector& tip) noexcept {
  return eccentricity(world.oval.stretched(tip), arm);
}

}  // namespace

double printed_length(const World& world, const FrozenCoefficients& frozen) noexcept {
  return std::max(0.0, frozen.length - world.end.behind);
}

double printed_arm(const World& world, const FrozenCoefficients& frozen) noexcept {
  const double length = printed_length(world, frozen);
  const bool acts = frozen.contact.side == EdgeSide::throat && length > 0;
  return acts && has_printed_forces(world) ? world.end.behind + 0.5 * length : 0;
}

double printed_gap(const World& world, const FrozenCoefficients& frozen,
                   const PoseVector& tip) noexcept {
  const double arm = printed_arm(world, frozen);
  if (arm == 0) return INFINITY;
  return world.annulus.clearance() - printed_eccentricity(world, arm, tip).norm();
}

bool near_printed_well(const World& world, const FrozenCoefficients& frozen,
                       const std::array<ContactDepth, kContactPlaces>& depth, const PoseVector& tip,
                       double distance) noexcept {
  if (!has_printed_wells(world.laws)) return false;
  if (std::holds_alternative<printed::Adhesion>(world.laws.adhesion) &&
      std::max(depth[kEnd].value, depth[kSide].value) > -distance)
    return true;
  return std::abs(printed_gap(world, frozen, tip)) < distance;
}

bool in_printed_well(const World& world, const FrozenCoefficients& frozen,
                     const PoseVector& tip) noexcept {
  return std::abs(printed_gap(world, frozen, tip)) < kInteratomicDistance;
}

PoseVector keep_in_printed_well(const World& world, const FrozenCoefficients& frozen,
                                const PoseVector& tip, const PoseVector& move,
                                const PoseVector& end) noexcept {
  const double arm = printed_arm(world, frozen), clearance = world.annulus.clearance();
  const Vector2d from = printed_eccentricity(world, arm, tip),
                 to = printed_eccentricity(world, arm, end);
  const double radius = from.norm(), off = to.norm();
  if (!(off > 0.5 * clearance)) return end;
  const double wanted = radius + from.dot(printed_eccentricity(world, arm, move)) / radius;
  const bool about_end = tip.e.squaredNorm() > eccentricity(tip, -tip.x).squaredNorm();
  const double pivot = about_end ? 0 : std::max(-end.x, 2 * arm);
  const Vector2d turn = (wanted / off - 1) / (arm - pivot) * (world.oval.stretch.inverse() * to);
  PoseVector turned = end;
  turned.e -= pivot * turn;
  turned.t += turn;
  return turned;
}

}  // namespace ferrule
