#include "sim/solver/line_search.hpp"

#include <algorithm>
#include <cmath>

#include "sim/solver/find_root.hpp"
#include "sim/solver/newton.hpp"

namespace ferrule {
namespace {

constexpr double kOvershoot = 0.3;       // of the slope at the start: a step may end rising by that
constexpr double kBarrierStep = 50e-12;  // less than a barrier of adhesion is wide [m]
constexpr int kBarrierSteps = 20;        // as wide as one
constexpr double kBarrierSlope = 0.05;   // of the slope at the start: a barrier rises more

// Where to bisect: a part may be small.
double between(double low, double high) noexcept {
  return low < 1e-3 * high ? std::max(0.03 * high, std::sqrt(low * high)) : 0.5 * (low + high);
}

}  // namespace

MeritModel::MeritModel(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                       const NonsmoothTerms& start, const NewtonStep& newton) noexcept
    : world_(world), frozen_(frozen), tip_(tip), start_(start), newton_(newton) {
  for (const NonsmoothTerm& law : start)
    if (law.acts) {
      const double rate = law.slope.dot(newton.move);
      deepening_ = std::max(deepening_, std::abs(rate));
      slope_ += law.force * rate;
      curve_ += law.stiffness * rate * rate;
    }
}

NonsmoothTerms MeritModel::terms(double part) const noexcept {
  return nonsmooth_terms(world_, frozen_, retract(world_, frozen_, tip_, part * newton_.move),
                         start_[kSide].share);
}

MeritValue MeritModel::at(double part, const NonsmoothTerms& end) const noexcept {
  MeritValue sum{
      -newton_.predicted_decrease * part * (1 - 0.5 * part) - part * (slope_ + 0.5 * part * curve_),
      -newton_.predicted_decrease * (1 - part) - slope_ - part * curve_, 0};
  for (std::size_t i = 0; i < kNonsmoothTerms; ++i) {
    if (!start_[i].acts || !end[i].acts) continue;
    sum.energy += end[i].energy - start_[i].energy;
    sum.rounding += world_.numerics.solver.force_tolerance *
                    (std::abs(end[i].energy) + std::abs(start_[i].energy));
    sum.slope += end[i].force * end[i].slope.dot(newton_.move);
  }
  return sum;
}

double MeritModel::least() const noexcept {
  const double limit = kOvershoot * newton_.predicted_decrease;
  const auto rises = [&](const MeritValue& value) { return value.slope > limit || higher(value); };
  double low = 0, high = first_barrier();
  if (high == 1 && !rises(at(1, terms(1)))) return 1;
  for (int n = 0; n < kBisections; ++n) {
    const double middle = between(low, high);
    const MeritValue value = at(middle, terms(middle));
    if (rises(value))
      high = middle;
    else if (value.slope < -limit)
      low = middle;
    else
      return middle;
  }
  return high;
}

double MeritModel::largest_adhesion(double most) const noexcept {
  if (!std::holds_alternative<Adhesion>(world_.laws.adhesion)) return most;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const NonsmoothTerm& start = start_[place];
    if (!start.acts || !(start.stiffness > 0) || !(start.slope.dot(newton_.move) < 0)) continue;
    const auto holds = [&](double part) {
      const NonsmoothTerm term = terms(part)[place];
      return term.acts && term.stiffness > 0;
    };
    if (holds(most)) continue;
    const auto end = bisect(Bracket<double>{0, most}, kBisections, holds, between);
    if (end.holds > 0 && terms(end.holds)[place].force < 0) most = end.fails;
  }
  return most;
}

// The part at which the energy first rises: what lies behind a barrier of adhesion may be lower.
// Not looked for among printed laws, whose longest steps it would double.
double MeritModel::first_barrier() const noexcept {
  if (has_printed_wells(world_.laws)) return 1;
  for (int n = 1; n <= kBarrierSteps; ++n) {
    const double part = n * kBarrierStep / deepening_;
    if (!(part < 1)) break;
    if (at(part, terms(part)).slope > kBarrierSlope * newton_.predicted_decrease) return part;
  }
  return 1;
}

}  // namespace ferrule
