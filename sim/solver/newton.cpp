#include "sim/solver/newton.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "sim/solver/line_search.hpp"
#include "sim/terms/contact.hpp"
#include "sim/terms/printed_well.hpp"

namespace ferrule {
namespace {

constexpr double kForceFloor = 1e-14;  // [N]
// Near printed surfaces, whose wells are 0.1 nm wide, instead of SolverParameters::final_residual
// and final_move.
constexpr double kFinalResidualInWell = 1e-6, kFinalMoveInWell = 2e-5;
constexpr double kNearWall = 10e-9;  // moves that begin so near to a wall go along it [m]
constexpr double kShortestLever =
    1e-6;                              // inserted length at which tilts are those of two places [m]
constexpr double kFarthestTurn = 1.0;  // [rad]
constexpr double kLeastSlope =
    0.1;                         // of the predicted decrease, or friction changes along the move
constexpr double kMaxRise = 10;  // of the predicted decrease, where the residual falls
constexpr double kModelError =
    1e-4;  // of the sum of all forces: of nonsmooth terms at the end of a step
constexpr int kMaxRounds = 3;
constexpr double kExpansion = 3;  // of a step along which the energy got ever steeper
constexpr int kMaxExpansions = 4;
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

// What a term bends by where its force is so much more: along the wall.
void add_bend(double more, const NonsmoothTerm& term, PoseMatrix& hessian) noexcept {
  const Matrix2d bend = more * term.curvature;
  hessian.ee += bend;
  hessian.et += term.arm * bend;
  hessian.tt += term.arm * term.arm * bend;
}

// A Newton step whose model has the nonsmooth terms as they are where it ends, curved surfaces
// included, and not only where it begins: Newton's method again, for what costs little to compute.
// False where that does not converge; the step is as it was then.
bool meet_nonsmooth_terms(const World& world, const FrozenCoefficients& frozen,
                          const Energy& smooth, const PoseVector& tip, const NonsmoothTerms& terms,
                          double tolerance, NewtonStep& newton) noexcept {
  NewtonStep step = newton;
  NonsmoothTerms model = terms;
  const MeritModel merit(world, frozen, tip, terms, newton);
  for (int round = 0; round < kMaxRounds; ++round) {
    double part = 1;
    NonsmoothTerms end =
        nonsmooth_terms(world, frozen, retract(world, frozen, tip, step.move), terms[kSide].share);
    if (round == 0 && merit.higher(merit.at(1, end))) {
      // Beyond a wall or a well, which it must meet and not jump.
      part = merit.least();
      end = merit.terms(part);
    }
    double error = 0;
    Energy bent = smooth;
    for (std::size_t i = 0; i < kNonsmoothTerms; ++i) {
      if (!terms[i].acts) continue;
      if (!end[i].acts) return false;
      const double on = part * terms[i].slope.dot(step.move);
      error = std::max(error, std::abs(end[i].force - model[i].force - model[i].stiffness * on));
      // Force and stiffness of the model where the pose is `tip`.
      const double stiffness = std::max(end[i].stiffness, 0.0);
      model[i].stiffness = stiffness;
      model[i].force = end[i].force - stiffness * on;
      bent.gradient += (model[i].force - terms[i].force) * terms[i].slope;
      add_square(bent.hessian, stiffness - terms[i].stiffness, terms[i].slope);
      if (terms[i].arm > 0) add_bend(end[i].force - terms[i].force, terms[i], bent.hessian);
    }
    if (part == 1 && error <= tolerance) {
      if (round == 0) return true;
      // It must not leave a well for another one.
      double more =
          smooth.gradient.dot(step.move) + 0.5 * smooth.hessian.times(step.move).dot(step.move);
      for (std::size_t i = 0; i < kNonsmoothTerms; ++i) {
        if (!terms[i].acts) continue;
        const double on = terms[i].slope.dot(step.move);
        more +=
            end[i].energy - terms[i].energy - on * (terms[i].force + 0.5 * terms[i].stiffness * on);
      }
      if (!(more < newton.predicted_decrease)) return false;
      newton = step;
      return true;
    }
    step = NewtonStep(world, frozen, bent, tip);
    if (!step.convex) return false;
  }
  return false;
}

// Where between 0 and 1 a cubic with these values and slopes is least; they are its at 0 and 1.
double cubic_minimum(double value, double slope, double value_at_1, double slope_at_1) noexcept {
  const double a = slope + slope_at_1 - 2 * (value_at_1 - value);
  const double b = 3 * (value_at_1 - value) - 2 * slope - slope_at_1;
  const double root = b * b - 3 * a * slope;
  return root > 0 ? -slope / (b + std::sqrt(root)) : 0.5;
}

// Replaces a plain Newton step by the one to try, and says which.
struct Direction {
  bool meets;  // the nonsmooth terms where it ends
  const char* name;
};
Direction choose_direction(const World& world, const FrozenCoefficients& frozen,
                           const Energy& smooth, const Iterate& iterate,
                           const NonsmoothTerms& terms, NewtonStep& newton) noexcept {
  const PoseVector& gradient = iterate.potential.gradient;
  NewtonStep met = newton;
  if ((newton.convex || terms[kPrintedWell].acts) &&
      meet_nonsmooth_terms(world, frozen, smooth, iterate.tip, terms,
                           kModelError * iterate.potential.force_scale, met) &&
      gradient.dot(met.move) < 0) {
    newton = met;
    return {true, "step that meets the nonsmooth terms"};
  }
  if (!(gradient.dot(newton.move) < -kLeastSlope * newton.predicted_decrease)) {
    newton = NewtonStep(world, frozen, smooth, iterate.tip, 1);
    return {false, "step with friction as it is here"};
  }
  return {false, newton.convex ? "plain step" : "step along magnitudes of pivots"};
}

enum class Descent { lower, nowhere, ended };  // ended: evaluations are spent, or it is at an edge

// Takes a part of a step, less where that is not lower and more where it gets ever steeper.
Descent descend(const World& world, const FrozenCoefficients& frozen, const NewtonStep& newton,
                double part, int max_evaluations, bool past_edges, Iterate& iterate) noexcept {
  const Potential start = iterate.potential;
  const PoseVector tip = iterate.tip;
  const double left = residual(world, start.gradient), slope = start.gradient.dot(newton.move);
  const double length = length_of(world, frozen, newton.move);
  // Energies and gradients are of tables and quadratures: where the drop drowns in what these
  // differ by, a residual that falls decides.
  const double level = std::max(kMaxRise * newton.predicted_decrease,
                                world.numerics.solver.force_tolerance * start.value_scale);
  Descent descent = Descent::nowhere;
  for (int expansions = 0; part * length >= kShortestTrial;) {
    if (iterate.evaluations >= max_evaluations) return Descent::ended;
    const PoseVector tried = retract(world, frozen, tip, part * newton.move);
    const Potential trial(world, frozen, tried);
    ++iterate.evaluations;
    const double more = trial.value - start.value, rise = trial.gradient.dot(newton.move);
    const bool lower = more < 1e-4 * part * slope ||
                       (more <= level && residual(world, trial.gradient) < 0.5 * left);
    if (descent == Descent::lower && !(trial.value < iterate.potential.value)) break;
    if (lower) {
      descent = Descent::lower;
      iterate.tip = tried;
      iterate.potential = trial;
      if (!(rise < slope && expansions++ < kMaxExpansions)) break;
      part *= kExpansion;  // into a well
      continue;
    }
    if (!past_edges &&
        (start.depth[kEnd].value == -INFINITY) != (trial.depth[kEnd].value == -INFINITY)) {
      iterate.at_edge = true;
      return Descent::ended;
    }
    part *=
        std::clamp(cubic_minimum(start.value, part * slope, trial.value, part * rise), 0.1, 0.5);
  }
  return descent;
}

}  // namespace

PoseVector retract(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                   const PoseVector& move) noexcept {
  const double clearance = world.annulus.clearance();
  const bool in_well = in_printed_well(world, frozen, tip);
  const double near = in_well ? 0.5 * clearance : std::max(clearance - kNearWall, 0.5 * clearance);
  PoseVector end = tip;
  end += move;
  end.e = turned(tip.e, move.e, near);
  const double length = -tip.x, length_at_end = -end.x;
  if (length > kShortestLever && length_at_end > kShortestLever) {
    const Vector2d mouth = tip.e + length * tip.t;
    if (mouth.norm() > near) {
      const Vector2d mouth_move = move.e + length * move.t - move.x * tip.t;
      const Vector2d mouth_at_end = turned(mouth, mouth_move, near);
      if (tip.e.norm() > near)
        end.t = (mouth_at_end - end.e) / length_at_end;
      else
        end.e += mouth_at_end - (mouth + mouth_move);
    }
  }
  return in_well ? keep_in_printed_well(world, frozen, tip, move, end) : end;
}

double residual(const World& world, const PoseVector& gradient) noexcept {
  return std::max(
      {std::abs(gradient.x), gradient.e.norm(), gradient.t.norm() / world.holder.tilt_length});
}

double length_of(const World& world, const FrozenCoefficients& frozen,
                 const PoseVector& move) noexcept {
  return move.length() + move.t.norm() * (frozen.length + world.annulus.fibre_radius);
}

TraceEntry entry(const Iterate& iterate, SolverStage stage, const char* reason, double part,
                 double move) noexcept {
  const Energy& potential = iterate.potential;
  return {
      stage, reason, part, iterate.evaluations, potential.gradient.length() / potential.force_scale,
      move};
}

NewtonStep stationary_step(const World& world, const FrozenCoefficients& frozen,
                           const Iterate& iterate) noexcept {
  const Energy& bore = iterate.potential.bore;
  return {world,
          frozen,
          without_friction(world, frozen, iterate.tip, bore.gradient, bore.hessian),
          iterate.tip,
          1,
          Pivots::as_they_are};
}

bool final_newton_step(const World& world, const std::array<FrozenFriction, kContactPlaces>& before,
                       const FrozenCoefficients& frozen, const PoseVector& move,
                       Iterate& iterate) noexcept {
  const SolverParameters& parameters = world.numerics.solver;
  Potential& potential = iterate.potential;
  const bool near_well = near_printed_well(world, frozen, potential.depth, iterate.tip, kNearWall);
  const double most = near_well ? kFinalResidualInWell : parameters.final_residual;
  const double longest = near_well ? kFinalMoveInWell : parameters.final_move;
  if (!(residual(world, potential.gradient) <= most * potential.force_scale &&
        length_of(world, frozen, move) <= longest * world.annulus.clearance() &&
        friction_agrees(world, before, frozen, iterate.tip, move, 1)))
    return false;
  note(iterate, SolverStage::newton, "converged: the last step needs no evaluation", world, move);
  potential.follow(move, iterate.tip);
  iterate.tip += move;
  iterate.converged = true;
  return true;
}

void minimise(const World& world, const FrozenCoefficients& frozen, int max_evaluations,
              bool past_edges, Iterate& iterate, const State* before) noexcept {
  const double tolerance = world.numerics.solver.force_tolerance;
  iterate.at_edge = false;
  for (;; ++iterate.iterations) {
    const Potential& potential = iterate.potential;
    if (before && iterate.evaluations > 1 &&
        contact_set_changed(*before, contacts(world, frozen, iterate.tip, potential)))
      return note(iterate, SolverStage::newton, "ends: contact set changed");
    const double left = residual(world, potential.gradient);
    if (left <= kForceFloor + tolerance * potential.force_scale) {
      iterate.converged = true;
      return note(iterate, SolverStage::newton, "converged: residual");
    }
    const Energy smooth = without_friction(world, frozen, iterate.tip, potential.bore.gradient,
                                           potential.bore.hessian);
    NewtonStep newton(world, frozen, smooth, iterate.tip);
    if (before && iterate.iterations > 0 && !newton.convex)
      return note(iterate, SolverStage::newton, "ends: concave");
    if (newton.convex && final_newton_step(world, frozen.friction, frozen, newton.move, iterate))
      return;
    const NonsmoothTerms terms =
        nonsmooth_terms(world, frozen, iterate.tip, side_share(world, frozen, iterate.tip));
    const Direction direction = choose_direction(world, frozen, smooth, iterate, terms, newton);
    const double length = length_of(world, frozen, newton.move);
    if (!(potential.gradient.dot(newton.move) < 0 && length >= kResolution)) {
      iterate.converged = length < kResolution || left <= kNearForce * potential.force_scale;
      return note(iterate, SolverStage::newton,
                  iterate.converged ? "converged: no shorter move" : "ends: no descent direction");
    }
    const MeritModel merit(world, frozen, iterate.tip, terms, newton);
    const double part = merit.largest_adhesion(direction.meets ? 1 : merit.least());
    const Descent descent =
        descend(world, frozen, newton, part, max_evaluations, past_edges, iterate);
    note(iterate, SolverStage::newton, direction.name, world, part * newton.move);
    if (descent == Descent::ended)
      return note(iterate, SolverStage::newton,
                  iterate.at_edge ? "ends: at an edge" : "ends: evaluations are spent");
    if (descent == Descent::nowhere) {  // rounding leaves nothing lower
      iterate.converged = left <= kNearForce * iterate.potential.force_scale ||
                          (newton.convex && length <= kUnresolved);
      return note(iterate, SolverStage::newton,
                  iterate.converged ? "converged: nothing lower" : "ends: nothing lower");
    }
  }
}

}  // namespace ferrule
