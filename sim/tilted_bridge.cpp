#include "sim/tilted_bridge.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/contact_depth.hpp"
#include "sim/laws/tilted_annulus.hpp"

namespace ferrule {
namespace {

// A place along the inserted length, and how it moves with the pose.
struct Cut {
  double arm = 0;       // [m]
  PoseVector per_pose;  // [1, m/rad]
};
constexpr std::size_t kMostCuts = 64;
const Quadrature kFewestNodes = Quadrature::gauss_legendre(5);  // the Hessian misleads with fewer
constexpr double kSteepest = 3;  // factor of a gap's distance from the law's singularity in one

}  // namespace

void add_tilted_bridge(Energy& total, PoseVector& gradient, const Capillary& law,
                       const World& world, bool bridge, const PoseVector& tip, double length,
                       double per_x) noexcept {
  const auto at = [&](double h) noexcept { return capillary(law, world.annulus, h, bridge); };
  const double c = world.annulus.clearance(), reach = capillary_reach(law, bridge);
  const double core = kRadialSmoothing * c;
  const double flat = core / length;  // a gap that changes less has no place where it is the reach
  const Vector2d e = tip.e, t = tip.t;

  const Quadrature& nodes = world.numerics.quadrature.order < kFewestNodes.order
                                ? kFewestNodes
                                : world.numerics.quadrature;
  std::array<Cut, kMostCuts> cuts;
  cuts[1] = {length, {per_x, Vector2d::Zero(), Vector2d::Zero()}};
  std::size_t count = 2;
  // Nearest the bore's axis.
  const double a = t.squaredNorm(), nearest = -e.dot(t) / a;
  if (a > flat * flat && nearest > 0 && nearest < length)
    cuts[count++] = {nearest, {0, -t / a, -(e + 2 * nearest * t) / a}};
  // Where the eccentricity is `radius`, and the force per length ends with the step `force`.
  const auto cut_at = [&](double radius, double force = 0) noexcept {
    const auto arms = radius > 0 ? arms_at(tip, radius) : std::nullopt;
    if (!arms) return;
    for (const double s : *arms) {
      if (!(s > 0 && s < length) || count == kMostCuts) continue;
      const Vector2d normal = eccentricity(tip, s) / radius;
      const double along = normal.dot(t), steep = std::max(std::abs(along), flat);
      const Vector2d per_e = -std::copysign(1 / steep, along) * normal;
      cuts[count++] = {s, {0, per_e, s * per_e}};
      if (force != 0)
        total.add_across(t, {s}, Vector2d::Zero(), force / steep * normal * normal.transpose());
    }
  };
  if (reach < c) cut_at(c - reach, at(std::nextafter(reach, 0)).force);
  cut_at(c);  // contact
  // Between them by equal factors of the distance from where the law is singular.
  const double scale = bridge_scale(law, world.annulus), most = 1 + std::min(reach, c) / scale;
  const double parts = std::ceil(std::log(most) / std::log(kSteepest));
  const double factor = std::pow(most, 1 / parts);
  for (double rise = factor; rise < 0.99 * most; rise *= factor) cut_at(c - scale * (rise - 1));
  // Near the bore's axis, where the direction turns.
  for (double radius = core; radius < 0.5 * c; radius *= 10)
    if (radius > c - reach) cut_at(radius);
  const auto end = cuts.begin() + static_cast<std::ptrdiff_t>(count);
  std::sort(cuts.begin(), end, [](const Cut& l, const Cut& r) { return l.arm < r.arm; });

  for (auto to = cuts.begin() + 1; to != end; ++to) {
    const Cut& from = *(to - 1);
    const double width = to->arm - from.arm;
    if (c - Radial(eccentricity(tip, from.arm + 0.5 * width), c).eccentricity >= reach) continue;
    double by_from = 0, by_to = 0;
    for (std::size_t n = 0; n < static_cast<std::size_t>(nodes.order); ++n) {
      const double node = nodes.node[n], weight = nodes.weight[n];
      const double arm = from.arm + node * width, part = weight * width;
      const Radial radial(eccentricity(tip, arm), c);
      const LineForce force = at(c - radial.eccentricity);
      const Vector2d pull = part * force.force * radial.normal;
      const Matrix2d stiff = part * (force.force * radial.curving -
                                     force.slope * radial.normal * radial.normal.transpose());
      total.value += part * force.potential;
      total.value_scale += std::abs(part * force.potential);
      total.force_scale += std::abs(part * force.force);
      total.add_across(t, {arm}, pull, stiff);
      gradient.e += pull;
      gradient.t += arm * pull;
      const double along = pull.dot(t), gain = weight * force.potential;
      by_from += (1 - node) * along - gain;
      by_to += node * along + gain;
    }
    PoseVector moved = by_from * from.per_pose;
    moved += by_to * to->per_pose;
    total.gradient += moved;
    gradient += moved;
  }

  // A longer overlap gains the energy per length at the mouth.
  if (per_x == 0) return;
  const Radial mouth(eccentricity(tip, length), c);
  const LineForce force = at(c - mouth.eccentricity);
  const Vector2d pull = force.force * mouth.normal;
  total.force_scale += std::abs(force.potential);
  total.hessian.xx += pull.dot(t);
  total.hessian.xe += per_x * pull;
  total.hessian.xt += per_x * length * pull;
}

}  // namespace ferrule
