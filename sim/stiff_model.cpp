#include "sim/stiff_model.hpp"

#include <algorithm>
#include <cmath>

#include "sim/minimum.hpp"

namespace ferrule {
namespace {

constexpr double kOvershoot = 0.3;  // of the slope at the begin: a move may end rising by that
constexpr int kMostBisections = 8;
constexpr double kNarrow = 50e-12;   // narrower than a barrier of adhesion [m]
constexpr int kMostNarrow = 20;      // as wide as one
constexpr double kBarrier = 0.05;    // of the slope at the begin: a barrier rises more
constexpr double kShortest = 1e-12;  // part of a Newton step

// Where to bisect: a part may be small.
double between(double low, double high) noexcept {
  return low < 1e-3 * high ? std::max(0.03 * high, std::sqrt(low * high)) : 0.5 * (low + high);
}

}  // namespace

StiffModel::StiffModel(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                       const StiffLaws& here, const NewtonStep& newton) noexcept
    : world_(world), frozen_(frozen), tip_(tip), here_(here), newton_(newton) {
  for (const StiffLaw& law : here)
    if (law.acts) {
      const double rate = law.slope.dot(newton.move);
      deeper_ = std::max(deeper_, std::abs(rate));
      slope_ += law.force * rate;
      curve_ += law.stiffness * rate * rate;
    }
}

StiffLaws StiffModel::laws(double part) const noexcept {
  return stiff_laws(world_, frozen_, moved_along(world_, frozen_, tip_, part * newton_.move),
                    here_[kSide].share);
}

AlongStep StiffModel::at(double part, const StiffLaws& there) const noexcept {
  AlongStep sum{-newton_.fall * part * (1 - 0.5 * part) - part * (slope_ + 0.5 * part * curve_),
                -newton_.fall * (1 - part) - slope_ - part * curve_, 0};
  for (std::size_t i = 0; i < kStiffLaws; ++i) {
    if (!here_[i].acts || !there[i].acts) continue;
    sum.energy += there[i].energy - here_[i].energy;
    sum.rounding += kLevel * (std::abs(there[i].energy) + std::abs(here_[i].energy));
    sum.slope += there[i].force * there[i].slope.dot(newton_.move);
  }
  return sum;
}

double StiffModel::least(double most) const noexcept {
  const double limit = kOvershoot * newton_.fall;
  const auto rises = [&](const AlongStep& there) { return there.slope > limit || higher(there); };
  double low = 0, high = barrier(most);
  if (high == most && !rises(at(most, laws(most)))) return most;
  for (int n = 0; n < kMostBisections && high - low > kShortest * most; ++n) {
    const double middle = between(low, high);
    const AlongStep there = at(middle, laws(middle));
    if (rises(there))
      high = middle;
    else if (there.slope < -limit)
      low = middle;
    else
      return middle;
  }
  return high;
}

double StiffModel::strongest_pull(double most) const noexcept {
  if (!std::holds_alternative<Adhesion>(world_.laws.adhesion) || has_printed_wells(world_.laws))
    return most;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const StiffLaw& here = here_[place];
    if (!here.acts || !(here.stiffness > 0) || !(here.slope.dot(newton_.move) < 0)) continue;
    const auto holds = [&](double part) {
      const StiffLaw there = laws(part)[place];
      return there.acts && there.stiffness > 0;
    };
    if (holds(most)) continue;
    double low = 0, high = most;
    for (int n = 0; n < kMostBisections && high - low > kShortest * most; ++n) {
      const double middle = between(low, high);
      (holds(middle) ? low : high) = middle;
    }
    if (low > 0 && laws(low)[place].force < 0) most = high;
  }
  return most;
}

// The part, up to `most`, at which the energy first rises: what lies behind a barrier of adhesion
// may be lower. Not looked for among printed laws, which take much longer to evaluate.
double StiffModel::barrier(double most) const noexcept {
  if (has_printed_wells(world_.laws)) return most;
  for (int n = 1; n <= kMostNarrow; ++n) {
    const double part = n * kNarrow / deeper_;
    if (!(part < most)) break;
    if (at(part, laws(part)).slope > kBarrier * newton_.fall) return part;
  }
  return most;
}

}  // namespace ferrule
