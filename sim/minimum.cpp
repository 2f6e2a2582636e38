#include "sim/minimum.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/stiff_model.hpp"

namespace ferrule {
namespace {

constexpr double kForceTolerance = 1e-9;  // relative to the sum of all force magnitudes
constexpr double kForceFloor = 1e-14;     // [N]
// The last Newton step leaves the square of these, and needs no evaluation.
struct LastStep {
  double force;  // of the sum of all forces
  double move;   // of the clearance
};
constexpr LastStep kLastStep = {5e-4, 1e-4};
constexpr LastStep kLastStepInWell = {1e-6, 2e-5};  // near printed surfaces
constexpr double kNearWall = 10e-9;  // moves that begin so near to a wall go along it [m]
constexpr double kShortestLever =
    1e-6;                              // inserted length at which tilts are those of two places [m]
constexpr double kFarthestTurn = 1.0;  // [rad]
constexpr double kLeastSlope = 0.1;    // of a move's fall, or friction changes along it
constexpr double kMostRise = 10;  // of what a Newton step should gain, where the residual falls
constexpr double kMeets = 1e-4;   // of the sum of all forces: stiff laws at the end of a step
constexpr int kMostRounds = 3, kMostRoundsInWell = 6;
constexpr double kFurther = 3;  // a step that got ever steeper
constexpr int kMostExpansions = 4;
constexpr double kUnresolved = 1e-14;     // moves that change an energy by less than it rounds [m]
constexpr double kShortestTrial = 1e-19;  // the printed well is 1e12 N/m stiff [m]

// An eccentricity that moves on along the wall: sideways it turns about the bore's axis.
Vector2d turned(const Vector2d& e, const Vector2d& move, double near) noexcept {
  const double radius = e.norm();
  if (!(radius > near)) return e + move;
  const Vector2d out = e / radius, along(-out.y(), out.x());
  // The tangent of half the angle; the angle to first order.
  const double half = 0.5 * std::clamp(along.dot(move) / radius, -kFarthestTurn, kFarthestTurn);
  const double over = 1 / (1 + half * half), outwards = std::max(radius + out.dot(move), 0.0);
  return outwards * over * ((1 - half * half) * out + 2 * half * along);
}

// What the printed well's pull bends by where it is so much more: along the wall.
void bend_well(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
               double more, PoseMatrix& hessian) noexcept {
  const double arm = printed_arm(world, frozen);
  const Radial middle(eccentricity(world.oval.stretched(tip), arm), world.annulus.clearance());
  const Matrix2d bend = more * world.oval.stretch * middle.curving * world.oval.stretch;
  hessian.ee += bend;
  hessian.et += arm * bend;
  hessian.tt += arm * arm * bend;
}

// A Newton step whose model has the stiff laws as they are where it ends, bent surfaces included,
// and not only where it begins: Newton's method again, for what costs little to compute. False
// where that does not converge; the step is as it was then.
bool meet_stiff_laws(const World& world, const FrozenCoefficients& frozen, const Energy& smooth,
                     const PoseVector& tip, const StiffLaws& here, double tolerance,
                     NewtonStep& newton) noexcept {
  NewtonStep step = newton;
  StiffLaws model = here;
  const StiffModel along(world, frozen, tip, here, newton);
  const int most = here[kPrintedWell].acts ? kMostRoundsInWell : kMostRounds;
  for (int round = 0; round < most; ++round) {
    double part = 1;
    StiffLaws there =
        stiff_laws(world, frozen, moved_along(world, frozen, tip, step.move), here[kSide].share);
    if (round == 0 && along.higher(along.at(1, there))) {
      // Beyond a wall or a well, which it must meet and not jump.
      part = along.least(1);
      there = along.laws(part);
    }
    double miss = 0;
    Energy bent = smooth;
    for (std::size_t i = 0; i < kStiffLaws; ++i) {
      if (!here[i].acts) continue;
      if (!there[i].acts) return false;
      const double on = part * here[i].slope.dot(step.move);
      miss = std::max(miss, std::abs(there[i].force - model[i].force - model[i].stiffness * on));
      // Force and stiffness of the model where the pose is `tip`.
      const double stiffness = std::max(there[i].stiffness, 0.0);
      model[i].stiffness = stiffness;
      model[i].force = there[i].force - stiffness * on;
      bent.gradient += (model[i].force - here[i].force) * here[i].slope;
      add_square(bent.hessian, stiffness - here[i].stiffness, here[i].slope);
      if (i == kPrintedWell)
        bend_well(world, frozen, tip, there[i].force - here[i].force, bent.hessian);
    }
    if (part == 1 && miss <= tolerance) {
      if (round == 0) return true;
      // It must not leave a well for another one.
      double more =
          smooth.gradient.dot(step.move) + 0.5 * smooth.hessian.times(step.move).dot(step.move);
      for (std::size_t i = 0; i < kStiffLaws; ++i) {
        if (!here[i].acts) continue;
        const double on = here[i].slope.dot(step.move);
        more +=
            there[i].energy - here[i].energy - on * (here[i].force + 0.5 * here[i].stiffness * on);
      }
      if (!(more < newton.fall)) return false;
      newton = step;
      return true;
    }
    step = NewtonStep(world, frozen, bent, tip);
    if (!step.convex) return false;
  }
  return false;
}

// Where between 0 and 1 a cubic with these values and slopes is least; they are its at 0 and 1.
double cubic_minimum(double value, double slope, double value_there, double slope_there) noexcept {
  const double a = slope + slope_there - 2 * (value_there - value);
  const double b = 3 * (value_there - value) - 2 * slope - slope_there;
  const double root = b * b - 3 * a * slope;
  return root > 0 ? -slope / (b + std::sqrt(root)) : 0.5;
}

// The step to try from where `found` is, instead of a plain Newton step; whether it meets the stiff
// laws where it ends.
bool choose_step(const World& world, const FrozenCoefficients& frozen, const Energy& smooth,
                 const Minimum& found, const StiffLaws& laws, NewtonStep& newton) noexcept {
  const PoseVector& gradient = found.there.gradient;
  NewtonStep met = newton;
  if ((newton.convex || laws[kPrintedWell].acts) &&
      meet_stiff_laws(world, frozen, smooth, found.tip, laws, kMeets * found.there.force_scale,
                      met) &&
      gradient.dot(met.move) < 0) {
    newton = met;
    return true;
  }
  if (!(gradient.dot(newton.move) < -kLeastSlope * newton.fall))
    newton = NewtonStep(world, frozen, smooth, found.tip, 1);
  return false;
}

enum class Descent { lower, nowhere, ended };  // ended: evaluations are spent, or it is at an edge

// Where the printed laws turn within less than the clearance.
bool near_printed_well(const World& world, const FrozenCoefficients& frozen,
                       const Minimum& found) noexcept {
  if (!has_printed_wells(world.laws)) return false;
  const auto& depth = found.there.depth;
  if (std::holds_alternative<printed::Adhesion>(world.laws.adhesion) &&
      std::max(depth[kEnd].value, depth[kSide].value) > -kNearWall)
    return true;
  return std::abs(printed_gap(world, frozen, found.tip)) < kNearWall;
}

// Takes a part of a step, less where that is not lower and more where it gets ever steeper.
Descent descend(const World& world, const FrozenCoefficients& frozen, const NewtonStep& newton,
                double part, int most_evaluations, bool past_edges, Minimum& found) noexcept {
  const Potential here = found.there;
  const PoseVector tip = found.tip;
  const double left = residual(world, here.gradient), slope = here.gradient.dot(newton.move);
  const double way = travel_of(world, frozen, newton.move);
  // Energies and gradients are of tables and quadratures: where the drop drowns in what these
  // differ by, a residual that falls decides.
  const double level = std::max(kMostRise * newton.fall, kLevel * here.value_scale);
  Descent went = Descent::nowhere;
  for (int further = 0; part * way >= kShortestTrial;) {
    if (found.evaluations >= most_evaluations) return Descent::ended;
    const PoseVector trial = moved_along(world, frozen, tip, part * newton.move);
    const Potential there(world, frozen, trial);
    ++found.evaluations;
    const double more = there.value - here.value, rise = there.gradient.dot(newton.move);
    const bool lower = more < 1e-4 * part * slope ||
                       (more <= level && residual(world, there.gradient) < 0.5 * left);
    if (went == Descent::lower && !(there.value < found.there.value)) break;
    if (lower) {
      went = Descent::lower;
      found.tip = trial;
      found.there = there;
      if (!(rise < slope && further++ < kMostExpansions)) break;
      part *= kFurther;  // into a well
      continue;
    }
    if (!past_edges &&
        (here.depth[kEnd].value == -INFINITY) != (there.depth[kEnd].value == -INFINITY)) {
      found.at_edge = true;
      return Descent::ended;
    }
    part *= std::clamp(cubic_minimum(here.value, part * slope, there.value, part * rise), 0.1, 0.5);
  }
  return went;
}

}  // namespace

PoseVector moved_along(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                       const PoseVector& move) noexcept {
  const double clearance = world.annulus.clearance();
  const double gap = printed_gap(world, frozen, tip);
  const bool in_well = std::abs(gap) < kInteratomicDistance;
  const double near = in_well ? 0.5 * clearance : std::max(clearance - kNearWall, 0.5 * clearance);
  PoseVector end = tip;
  end += move;
  end.e = turned(tip.e, move.e, near);
  const double length = -tip.x, length_there = -end.x;
  if (length > kShortestLever && length_there > kShortestLever) {
    const Vector2d mouth = tip.e + length * tip.t;
    if (mouth.norm() > near) {
      const Vector2d mouth_move = move.e + length * move.t - move.x * tip.t;
      const Vector2d there = turned(mouth, mouth_move, near);
      if (tip.e.norm() > near)
        end.t = (there - end.e) / length_there;
      else
        end.e += there - (mouth + mouth_move);
    }
  }
  if (!in_well) return end;
  // In the printed well the middle keeps the gap that it would have to first order: the axis turns
  // about where the fibre is nearest to the wall, its end or the mouth.
  const double arm = printed_arm(world, frozen), radius = clearance - gap;
  const auto middle = [&](const PoseVector& at) {
    return eccentricity(world.oval.stretched(at), arm);
  };
  const Vector2d to = middle(end);
  const double there = to.norm(), wanted = radius + middle(tip).dot(middle(move)) / radius;
  if (!(there > near)) return end;
  const bool about_end = tip.e.squaredNorm() > eccentricity(tip, length).squaredNorm();
  const double pivot = about_end ? 0 : std::max(length_there, 2 * arm);
  const Vector2d turn = (wanted / there - 1) / (arm - pivot) * (world.oval.stretch.inverse() * to);
  end.e -= pivot * turn;
  end.t += turn;
  return end;
}

double residual(const World& world, const PoseVector& gradient) noexcept {
  return std::max(
      {std::abs(gradient.x), gradient.e.norm(), gradient.t.norm() / world.holder.tilt_length});
}

double travel_of(const World& world, const FrozenCoefficients& frozen,
                 const PoseVector& move) noexcept {
  return move.length() + move.t.norm() * (frozen.length + world.annulus.fibre_radius);
}

bool final_newton_step(const World& world, const FrozenCoefficients& frozen, const PoseVector& rest,
                       Minimum& found) noexcept {
  Potential& there = found.there;
  const LastStep most = near_printed_well(world, frozen, found) ? kLastStepInWell : kLastStep;
  if (!(residual(world, there.gradient) <= most.force * there.force_scale &&
        travel_of(world, frozen, rest) <= most.move * world.annulus.clearance()))
    return false;
  there.follow(rest, found.tip);
  found.tip += rest;
  found.converged = true;
  return true;
}

void minimise(const World& world, const FrozenCoefficients& frozen, int most_evaluations,
              bool past_edges, Minimum& found, const State* before) noexcept {
  const bool inserted = frozen.length > 0 && frozen.contact.side == EdgeSide::throat;
  double farthest = inserted ? world.annulus.clearance() : INFINITY;
  found.at_edge = false;
  for (;; ++found.iterations) {
    const Potential& here = found.there;
    const bool looks = before && found.evaluations > 1;
    if (looks && hits(*before, contacts(world, frozen, found.tip, here))) return;
    const double left = residual(world, here.gradient);
    if (left <= kForceFloor + kForceTolerance * here.force_scale) {
      found.converged = true;
      return;
    }
    const Energy smooth =
        without_friction(frozen, found.tip, here.bore.gradient, here.bore.hessian);
    NewtonStep newton(world, frozen, smooth, found.tip);
    if (before && found.iterations > 0 && !newton.convex) return;
    if (newton.convex && final_newton_step(world, frozen, newton.move, found)) return;
    const StiffLaws laws =
        stiff_laws(world, frozen, found.tip, side_share(world, frozen, found.tip));
    const bool meets = choose_step(world, frozen, smooth, found, laws, newton);
    const double way = travel_of(world, frozen, newton.move);
    if (!(here.gradient.dot(newton.move) < 0 && way >= kResolution)) {
      found.converged = way < kResolution || left <= kNearForce * here.force_scale;
      return;
    }
    // Among surface forces a step longer than the clearance tells nothing, until it does.
    const double turn = newton.move.t.norm() * (frozen.length + world.annulus.fibre_radius);
    const double reach = std::max(newton.move.e.norm(), turn);
    double part = reach > farthest ? farthest / reach : 1;
    const bool bounded = part < 1;
    const StiffModel along(world, frozen, found.tip, laws, newton);
    if (!meets || bounded) part = along.least(part);
    part = along.strongest_pull(part);
    const Descent went = descend(world, frozen, newton, part, most_evaluations, past_edges, found);
    if (went == Descent::ended) return;
    if (went == Descent::nowhere) {  // rounding leaves nothing lower
      found.converged =
          left <= kNearForce * found.there.force_scale || (newton.convex && way <= kUnresolved);
      return;
    }
    if (bounded) farthest *= 2;
  }
}

}  // namespace ferrule
