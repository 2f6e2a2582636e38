#include "sim/terms/tilted_bridge.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/base/elementary.hpp"
#include "sim/geometry/contact_depth.hpp"
#include "sim/laws/tilted_annulus.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kMostCuts = 64;
const Quadrature kFewestNodes = Quadrature::gauss_legendre(5);  // the Hessian misleads with fewer
constexpr double kSteepest = 3;  // factor of a gap's distance from the law's singularity in one

// The bridge along the inserted length of one pose.
struct Bridge {
  Bridge(const Capillary& capillary_law, const Annulus& around, bool there, const PoseVector& pose,
         double inserted) noexcept
      : law(capillary_law),
        annulus(around),
        present(there),
        tip(pose),
        length(inserted),
        clearance(around.clearance()),
        range(capillary_range(capillary_law, there)),
        core(kRadialSmoothing * clearance),
        flat(core / inserted) {}

  LineForce at(double gap) const noexcept { return capillary(law, annulus, gap, present); }
  Radial radial(double arm) const noexcept { return {eccentricity(tip, arm), clearance}; }

  const Capillary& law;
  const Annulus& annulus;
  bool present;
  PoseVector tip;
  double length, clearance, range;  // [m]
  double core;                      // the eccentricity within which its direction turns [m]
  double flat;  // the slope of a gap below which there is no place where it is the range [1]
};

// A place along the inserted length, and how it moves with the pose.
struct Cut {
  double arm = 0;       // [m]
  PoseVector per_pose;  // [1, m/rad]
};

// The places between which the force per length is smooth, in order along the length.
class Cuts {
 public:
  // Adds to the Hessian of `total` where the force per length ends with a step.
  Cuts(const Bridge& bridge, double per_x, Energy& total) noexcept {
    add_ends(bridge, per_x);
    const double c = bridge.clearance, range = bridge.range;
    if (range < c) add(bridge, c - range, total, bridge.at(std::nextafter(range, 0)).force);
    add(bridge, c, total);  // contact
    // Between them by equal factors of the distance from where the law is singular.
    const double scale = bridge_scale(bridge.law, bridge.annulus);
    const double most = 1 + std::min(range, c) / scale;
    const double log_most = elementary::log(most);
    const double factor =
        elementary::exp(log_most / std::ceil(log_most / elementary::log(kSteepest)));
    for (double rise = factor; rise < 0.99 * most; rise *= factor)
      add(bridge, c - scale * (rise - 1), total);
    // Near the bore's axis, where the direction turns.
    for (double radius = bridge.core; radius < 0.5 * c; radius *= 10)
      if (radius > c - range) add(bridge, radius, total);
    std::sort(cut_.begin(), cut_.begin() + static_cast<std::ptrdiff_t>(count_),
              [](const Cut& l, const Cut& r) { return l.arm < r.arm; });
  }

  std::size_t size() const noexcept { return count_; }
  const Cut& operator[](std::size_t k) const noexcept { return cut_[k]; }

 private:
  // The end, the mouth, and between them where the fibre is nearest the bore's axis.
  void add_ends(const Bridge& bridge, double per_x) noexcept {
    const double length = bridge.length;
    const Vector2d e = bridge.tip.e, t = bridge.tip.t;
    cut_[1] = {length, {per_x, Vector2d::Zero(), Vector2d::Zero()}};
    count_ = 2;
    const double a = t.squaredNorm(), nearest = -e.dot(t) / a;
    if (a > bridge.flat * bridge.flat && nearest > 0 && nearest < length)
      cut_[count_++] = {nearest, {0, -t / a, -(e + 2 * nearest * t) / a}};
  }

  // Where the eccentricity is `radius`, and the force per length ends with the step `force`.
  void add(const Bridge& bridge, double radius, Energy& total, double force = 0) noexcept {
    const auto arms = radius > 0 ? arms_at(bridge.tip, radius) : std::nullopt;
    if (!arms) return;
    const Vector2d t = bridge.tip.t;
    for (const double s : *arms) {
      if (!(s > 0 && s < bridge.length) || count_ == kMostCuts) continue;
      const Vector2d normal = eccentricity(bridge.tip, s) / radius;
      const double along = normal.dot(t), steep = std::max(std::abs(along), bridge.flat);
      const Vector2d per_e = -std::copysign(1 / steep, along) * normal;
      cut_[count_++] = {s, {0, per_e, s * per_e}};
      if (force != 0)
        total.add_across(t, {s}, Vector2d::Zero(), force / steep * normal * normal.transpose());
    }
  }

  std::array<Cut, kMostCuts> cut_;
  std::size_t count_ = 0;
};

// The bridge between two cuts.
void add_piece(Energy& total, PoseVector& gradient, const Bridge& bridge, const Quadrature& nodes,
               const Cut& from, const Cut& to) noexcept {
  const Vector2d t = bridge.tip.t;
  const double width = to.arm - from.arm;
  if (bridge.clearance - bridge.radial(from.arm + 0.5 * width).eccentricity >= bridge.range) return;
  const auto count = static_cast<std::size_t>(nodes.order);
  std::array<double, kMostNodes> gap;
  for (std::size_t n = 0; n < count; ++n)
    gap[n] = bridge.clearance - bridge.radial(from.arm + nodes.node[n] * width).eccentricity;
  std::array<LineForce, kMostNodes> forces;
  capillary(bridge.law, bridge.annulus, bridge.present, {gap.data(), count},
            {forces.data(), count});
  double by_from = 0, by_to = 0;
  for (std::size_t n = 0; n < count; ++n) {
    const double node = nodes.node[n], weight = nodes.weight[n];
    const double arm = from.arm + node * width, part = weight * width;
    const Radial radial = bridge.radial(arm);
    const LineForce& force = forces[n];
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
  moved += by_to * to.per_pose;
  total.gradient += moved;
  gradient += moved;
}

// A longer overlap gains the energy per length at the mouth.
void add_mouth(Energy& total, const Bridge& bridge, double per_x) noexcept {
  const Radial mouth = bridge.radial(bridge.length);
  const LineForce force = bridge.at(bridge.clearance - mouth.eccentricity);
  const Vector2d pull = force.force * mouth.normal;
  total.force_scale += std::abs(force.potential);
  total.hessian.xx += pull.dot(bridge.tip.t);
  total.hessian.xe += per_x * pull;
  total.hessian.xt += per_x * bridge.length * pull;
}

}  // namespace

void add_tilted_bridge(Energy& total, PoseVector& gradient, const Capillary& law,
                       const World& world, bool bridge, const PoseVector& tip, double length,
                       double per_x) noexcept {
  const Quadrature& nodes = world.numerics.quadrature.order < kFewestNodes.order
                                ? kFewestNodes
                                : world.numerics.quadrature;
  const Bridge liquid(law, world.annulus, bridge, tip, length);
  const Cuts cuts(liquid, per_x, total);
  for (std::size_t k = 1; k < cuts.size(); ++k)
    add_piece(total, gradient, liquid, nodes, cuts[k - 1], cuts[k]);
  if (per_x != 0) add_mouth(total, liquid, per_x);
}

}  // namespace ferrule
