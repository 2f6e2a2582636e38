#include "sim/terms/surface_forces.hpp"

#include <algorithm>
#include <cmath>

#include "sim/geometry/contact_depth.hpp"
#include "sim/laws/tilted_annulus.hpp"
#include "sim/terms/tilted_bridge.hpp"

namespace ferrule {
namespace {

const Quadrature kMiddle;  // the one gap that printed forces know

// The closed form replaces the exact cylinders where it is as good as these.
constexpr double kClosedFormError = 1e-3;
constexpr double kOnset = 10e-9;  // inserted length in which the laws begin, and end [m]

// The inserted length of the pose itself that the laws act along, with its derivatives by x. At the
// begin it grows from 0 within kOnset, with two continuous derivatives, as a wall that pushes would
// make an edge of the energy there, and so it stops growing at the other end of the bore, where one
// that pulls would: l p^2 (6 - 8 p + 3 p^2), p = l/kOnset, of what is inserted, or is left.
struct Overlap {
  double length = 0, slope = 0, curve = 0;  // [m], [-], [1/m]

  Overlap(const World& world, const PoseVector& tip) noexcept {
    const double inserted = -tip.x, left = world.profile.length - inserted;
    if (!(inserted > 0)) return;
    length = inserted;
    slope = -1;
    if (inserted < kOnset) {
      grow(inserted);
    } else if (left < kOnset) {
      grow(std::max(left, 0.0));
      length = world.profile.length - length;
      curve = -curve;
    }
  }

 private:
  void grow(double l) noexcept {
    const double p = l / kOnset;
    length = l * p * p * (6 - p * (8 - 3 * p));
    slope = -p * p * (18 - p * (32 - 15 * p));
    curve = p * (36 - p * (96 - 60 * p)) / kOnset;
  }
};

// Laws that are summed over nodes, those of one form: force per length at a gap, null where there
// is none.
struct PrintedLaws {
  const Annulus& annulus;
  const printed::VanDerWaals* van_der_waals;
  const printed::Electrostatic* electrostatic;
  const printed::Capillary* capillary;

  explicit PrintedLaws(const World& world) noexcept
      : annulus(world.annulus),
        van_der_waals(std::get_if<printed::VanDerWaals>(&world.laws.van_der_waals)),
        electrostatic(std::get_if<printed::Electrostatic>(&world.laws.electrostatic)),
        capillary(std::get_if<printed::Capillary>(&world.laws.capillary)) {}
  bool any() const noexcept { return van_der_waals || electrostatic || capillary; }

  template <class Add>
  void at(double h, const Add& add) const noexcept {
    if (van_der_waals) add(kVanDerWaals, printed::van_der_waals(*van_der_waals, annulus, h));
    if (electrostatic) add(kElectrostatic, printed::electrostatic(*electrostatic, annulus, h));
    if (capillary) add(kCapillary, printed::capillary(*capillary, h));
  }
};

struct CorrectedLaws {
  const Annulus& annulus;
  const VanDerWaals* van_der_waals;
  const Electrostatic* electrostatic;

  bool any() const noexcept { return van_der_waals || electrostatic; }

  template <class Add>
  void at(double h, const Add& add) const noexcept {
    if (van_der_waals) add(kVanDerWaals, ferrule::van_der_waals(*van_der_waals, annulus, h));
    if (electrostatic) add(kElectrostatic, ferrule::electrostatic(*electrostatic, annulus, h));
  }
};

// Over `length`, which changes by `slope` with x.
template <class Laws>
void add_nodes(Energy& total, const Laws& laws, const Quadrature& quadrature, double length,
               double slope, const PoseVector& tip, SurfaceGradients& by_term) noexcept {
  const double c = laws.annulus.clearance();
  const Vector2d tilt = tip.t;
  for (int n = 0; n < quadrature.order; ++n) {
    const double node = quadrature.node[static_cast<std::size_t>(n)];
    const double weight = quadrature.weight[static_cast<std::size_t>(n)];
    const Arm arm{node * length, node * slope};
    const Radial radial(eccentricity(tip, arm.length), c);
    LineForce sum;
    laws.at(c - radial.eccentricity, [&](SurfaceTerm term, const LineForce& law) {
      sum.potential += law.potential;
      sum.force += law.force;
      sum.slope += law.slope;
      PoseVector& g = by_term[term];
      const Vector2d pull = weight * length * law.force * radial.normal;
      g.x += slope * weight * law.potential + arm.per_x * pull.dot(tilt);
      g.e += pull;
      g.t += arm.length * pull;
    });

    // The sum is length times the mean: the chain rule through both.
    const double part = weight * length;
    const Vector2d pull = part * sum.force * radial.normal;
    const Matrix2d stiff =
        part * (sum.force * radial.curving - sum.slope * radial.normal * radial.normal.transpose());
    total.value += part * sum.potential;
    total.value_scale += std::abs(part * sum.potential);
    total.add_across(tilt, arm, pull, stiff);
    total.force_scale += std::abs(part * sum.force);
    if (slope == 0) continue;
    const Vector2d per_length = weight * slope * sum.force * radial.normal;
    total.gradient.x += slope * weight * sum.potential;
    total.force_scale += std::abs(slope * weight * sum.potential);
    total.hessian.xx += 2 * arm.per_x * per_length.dot(tilt);
    total.hessian.xe += per_length;
    total.hessian.xt += arm.length * per_length;
  }
}

// Where along the length the mean surfaces are apart: between the two arms. Outside, towards an
// end, they touch.
struct Apart {
  double from, to;
};
Apart apart(const PoseVector& tip, double length, double widest) noexcept {
  const Vector2d e = tip.e, t = tip.t;
  const double limit = widest * widest;
  const bool begins_apart = e.squaredNorm() <= limit;
  const bool ends_apart = (e + length * t).squaredNorm() <= limit;
  if (begins_apart && ends_apart) return {0, length};
  const auto touching = arms_at(tip, widest);
  if (!touching) return {0, 0};
  const auto [first, second] = *touching;
  const double from = begins_apart ? 0 : std::clamp(first, 0.0, length);
  const double to = ends_apart ? length : std::clamp(second, 0.0, length);
  return from < to ? Apart{from, to} : Apart{0, 0};
}

// The closed-form laws at one eccentricity: energy per length and force over eccentricity, of van
// der Waals and electrostatics.
struct LocalLaw {
  std::array<double, 2> value, per_e;

  LocalLaw(const TiltedAnnulus& law, double squared_eccentricity) noexcept {
    const double q = 1 / (law.clearance * law.clearance - squared_eccentricity);
    const double single = law.single * std::sqrt(q), cubed = law.cubed * std::sqrt(q) * q;
    value = {-cubed, -single};
    per_e = {-3 * cubed * q, -single * q};
  }
};

const Quadrature kTouchingNodes = Quadrature::gauss_legendre(4);

// The intervals where the mean surfaces touch and the laws end (sim/laws/corrected_range.hpp), by
// Gauss-Legendre of order 4, exact where they are parabolas: the nodes are computed side by side.
class Touching {
 public:
  using Nodes = Eigen::Array4d;

  // Force and energy per length at the closest, `thinnest` apart from contact [N/m], [J/m].
  Touching(double closest, double thinnest, double force, double value) noexcept
      : closest_(closest), per_thinnest_(1 / thinnest), at_closest_(force), value_at_(value) {}

  void add(const PoseVector& tip, double from, double to) noexcept {
    const Nodes weight = (to - from) * Nodes(kTouchingNodes.weight.data());
    const Nodes steepest = at_closest_ * weight;
    const Nodes arm = from + (to - from) * Nodes(kTouchingNodes.node.data());
    const Nodes y = tip.e.x() + arm * tip.t.x(), z = tip.e.y() + arm * tip.t.y();
    const Nodes radius = (y * y + z * z).sqrt(), inverse = 1 / radius;
    const Nodes over = radius - closest_, part = over * per_thinnest_;
    const Nodes value = value_at_ * weight + steepest * over * (1 - 0.5 * part);
    const Nodes force = steepest * (1 - part), per_e = force * inverse;
    const Nodes along = (per_e + steepest * per_thinnest_) * inverse * inverse;
    value_ += value;
    value_scale_ += value.abs();
    force_scale_ += force.abs();
    const Nodes pull_y = per_e * y, pull_z = per_e * z;
    pull_y_ += pull_y;
    pull_z_ += pull_z;
    turn_y_ += arm * pull_y;
    turn_z_ += arm * pull_z;
    yy_.add(arm, per_e - along * y * y);
    yz_.add(arm, -along * y * z);
    zz_.add(arm, per_e - along * z * z);
  }

  Vector2d pull() const noexcept { return {pull_y_.sum(), pull_z_.sum()}; }
  Vector2d turn() const noexcept { return {turn_y_.sum(), turn_z_.sum()}; }

  void add_to(Energy& total) const noexcept {
    total.value += value_.sum();
    total.value_scale += value_scale_.sum();
    total.force_scale += force_scale_.sum();
    total.gradient.e += pull();
    total.gradient.t += turn();
    total.hessian.ee += symmetric(yy_.zeroth, yz_.zeroth, zz_.zeroth);
    total.hessian.et += symmetric(yy_.first, yz_.first, zz_.first);
    total.hessian.tt += symmetric(yy_.second, yz_.second, zz_.second);
  }

 private:
  // Sums over the nodes of a quantity times powers of the arm.
  struct Moments {
    Nodes zeroth = Nodes::Zero(), first = Nodes::Zero(), second = Nodes::Zero();

    void add(const Nodes& arm, const Nodes& quantity) noexcept {
      const Nodes once = arm * quantity;
      zeroth += quantity;
      first += once;
      second += arm * once;
    }
  };

  static Matrix2d symmetric(const Nodes& yy, const Nodes& yz, const Nodes& zz) noexcept {
    const double mixed = yz.sum();
    Matrix2d m;
    m.col(0) = Vector2d(yy.sum(), mixed);
    m.col(1) = Vector2d(mixed, zz.sum());
    return m;
  }

  double closest_, per_thinnest_, at_closest_, value_at_;
  Nodes value_ = Nodes::Zero(), value_scale_ = Nodes::Zero(), force_scale_ = Nodes::Zero();
  Nodes pull_y_ = Nodes::Zero(), pull_z_ = Nodes::Zero();
  Nodes turn_y_ = Nodes::Zero(), turn_z_ = Nodes::Zero();
  Moments yy_, yz_, zz_;
};

constexpr std::array<SurfaceTerm, 2> kInClosedForm = {kVanDerWaals, kElectrostatic};

// The parts of the fibre nearer the wall than its roughness, before and after the free one.
void add_touching_parts(Energy& total, SurfaceGradients& by_term, const LocalLaw& end,
                        double widest, double thinnest, const PoseVector& tip, double length,
                        const Apart& free) noexcept {
  const double at_edge = widest * (end.per_e[0] + end.per_e[1]);
  if (at_edge == 0 || !(free.from > 0 || free.to < length)) return;
  Touching touching(widest, thinnest, at_edge, end.value[0] + end.value[1]);
  if (free.from > 0) touching.add(tip, 0, free.from);
  if (free.to < length) touching.add(tip, free.to, length);
  touching.add_to(total);
  const double per_edge = widest / at_edge;
  for (std::size_t i = 0; i < kInClosedForm.size(); ++i) {
    const double share = per_edge * end.per_e[i];
    by_term[kInClosedForm[i]].e += share * touching.pull();
    by_term[kInClosedForm[i]].t += share * touching.turn();
  }
}

// The part of the fibre that is free of the wall.
void add_free_part(Energy& total, SurfaceGradients& by_term, const TiltedAnnulus& law,
                   const PoseVector& tip, const Apart& free) noexcept {
  const double part = free.to - free.from;
  // The mean over the part of the laws times its length.
  const LineMean mean = line_mean({law.clearance, part * law.cubed, part * law.single},
                                  eccentricity(tip, free.from), eccentricity(tip, free.to));
  for (std::size_t i = 0; i < kInClosedForm.size(); ++i) {
    const Vector2d across = mean.by_a[i] + mean.by_b[i];
    const Vector2d turn = free.from * mean.by_a[i] + free.to * mean.by_b[i];
    by_term[kInClosedForm[i]].e += across;
    by_term[kInClosedForm[i]].t += turn;
    total.gradient.e += across;
    total.gradient.t += turn;
    total.value += mean.value[i];
    total.value_scale -= mean.value[i];
    total.force_scale += across.norm();
  }
  const Matrix2d to_a = mean.aa + mean.ba, to_b = mean.ab + mean.bb;  // columns by e_a, by e_b
  total.hessian.ee += to_a + to_b;
  total.hessian.et += free.from * to_a + free.to * to_b;
  total.hessian.tt += free.from * (free.from * mean.aa + free.to * mean.ab) +
                      free.to * (free.from * mean.ba + free.to * mean.bb);
}

// A longer overlap gains the energy per length at the mouth.
void add_closed_form_mouth(Energy& total, SurfaceGradients& by_term, const TiltedAnnulus& law,
                           const LocalLaw& end, double widest, double thinnest,
                           const PoseVector& tip, double length, double slope) noexcept {
  const Vector2d e = eccentricity(tip, length);
  const double radius2 = e.squaredNorm(), limit2 = widest * widest;
  const bool touches = radius2 > limit2;
  LocalLaw mouth = touches ? end : LocalLaw(law, radius2);
  if (touches) {
    const double radius = std::sqrt(radius2), over = radius - widest, part = over / thinnest;
    const double more = widest * over * (1 - 0.5 * part), less = widest / radius * (1 - part);
    for (std::size_t i = 0; i < kInClosedForm.size(); ++i) {
      mouth.value[i] += mouth.per_e[i] * more;
      mouth.per_e[i] *= less;
    }
  }
  for (std::size_t i = 0; i < kInClosedForm.size(); ++i)
    by_term[kInClosedForm[i]].x += slope * mouth.value[i];
  const double value = mouth.value[0] + mouth.value[1];
  const Vector2d force = (mouth.per_e[0] + mouth.per_e[1]) * e;
  total.gradient.x += slope * value;
  total.force_scale += std::abs(slope * value);
  total.hessian.xx += slope * slope * force.dot(tip.t);
  total.hessian.xe += slope * force;
  total.hessian.xt += slope * length * force;
}

void add_closed_form(Energy& total, const World& world, const TiltedAnnulus& law,
                     const Overlap& overlap, const PoseVector& tip,
                     SurfaceGradients& by_term) noexcept {
  const double length = overlap.length;
  const double widest = law.clearance - std::max(world.annulus.roughness, kInteratomicDistance);
  const double thinnest = law.clearance - widest;
  const Apart free = apart(tip, length, widest);
  const LocalLaw end(law, widest * widest);
  add_touching_parts(total, by_term, end, widest, thinnest, tip, length, free);
  if (free.to > free.from) add_free_part(total, by_term, law, tip, free);
  if (overlap.slope != 0)
    add_closed_form_mouth(total, by_term, law, end, widest, thinnest, tip, length, overlap.slope);
}

}  // namespace

bool has_printed_forces(const World& world) noexcept {
  return PrintedLaws(world).any();
}

LineForce printed_forces(const World& world, double h) noexcept {
  LineForce sum;
  PrintedLaws(world).at(h, [&](SurfaceTerm, const LineForce& law) {
    sum.potential += law.potential;
    sum.force += law.force;
    sum.slope += law.slope;
  });
  return sum;
}

bool electrostatic_in_closed_form(const World& world) noexcept {
  return world.numerics.closed_form &&
         std::holds_alternative<Electrostatic>(world.laws.electrostatic) &&
         closed_form_error(world.annulus) < kClosedFormError;
}

void add_surface_forces(Energy& total, SurfaceGradients& by_term, const World& world,
                        double printed_length, bool bridge, const PoseVector& tip) noexcept {
  const PrintedLaws printed(world);
  if (printed_length > 0 && printed.any())
    add_nodes(total, printed, kMiddle, printed_length, 0, tip, by_term);
  if (tip.x >= 0) return;
  const Overlap overlap(world, tip);
  const double along = total.gradient.x;
  const auto* attraction = std::get_if<VanDerWaals>(&world.laws.van_der_waals);
  const auto* charge = std::get_if<Electrostatic>(&world.laws.electrostatic);
  const bool attracts = attraction && world.numerics.closed_form;
  const bool charged = charge && electrostatic_in_closed_form(world);
  if (attracts || charged)
    add_closed_form(total, world,
                    TiltedAnnulus::of(attracts ? attraction : nullptr, charged ? charge : nullptr,
                                      world.annulus),
                    overlap, tip, by_term);
  if (const auto* liquid = std::get_if<Capillary>(&world.laws.capillary))
    add_tilted_bridge(total, by_term[kCapillary], *liquid, world, bridge, tip, overlap.length,
                      overlap.slope);
  const CorrectedLaws nodes{world.annulus, attracts ? nullptr : attraction,
                            charged ? nullptr : charge};
  if (nodes.any())
    add_nodes(total, nodes, world.numerics.quadrature, overlap.length, overlap.slope, tip, by_term);
  // By x all laws have only the energy at the mouth times the overlap's slope so far.
  if (overlap.curve != 0 && overlap.slope != 0)
    total.hessian.xx += overlap.curve / overlap.slope * (total.gradient.x - along);
}

bool bridge_at(const World& world, bool bridge, const PoseVector& tip) noexcept {
  if (tip.x >= 0 || !present(world.laws.capillary)) return false;
  const auto* law = std::get_if<Capillary>(&world.laws.capillary);
  if (!law) return true;  // the printed layer never lets go
  // The smallest gap is at an end of the length, the distance of a straight line from the axis
  // being convex.
  const double gap =
      world.annulus.clearance() -
      std::max(eccentricity(tip, 0).norm(), eccentricity(tip, Overlap(world, tip).length).norm());
  return gap < capillary_range(*law, bridge);
}

}  // namespace ferrule
