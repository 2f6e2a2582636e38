#include "sim/solver/predictor.hpp"

#include <cmath>

#include "sim/solver/find_root.hpp"
#include "sim/solver/friction_coupling.hpp"

namespace ferrule {
namespace {

// A Newton step and what the friction limits change along it; the whole move, if there is one.
// Limit and depth may hold each other in check within far less than either alone would change: to
// first order they change together from where the step begins.
std::optional<PoseVector> predict_with_friction(const World& world, const Energy& start,
                                                const PoseVector& tip, FrozenCoefficients& frozen,
                                                std::optional<NewtonStep>& newton) noexcept {
  const auto first = frozen.friction;
  newton.emplace(world, frozen, start, tip, 1, Pivots::as_they_are, true);
  const auto coupled = [&](const PoseVector& at, double slides_at) {
    return CoupledModel(*newton, FrictionCoupling(world, frozen, at, slides_at)).step(frozen);
  };
  auto move = coupled(tip, kSlidingOn);
  if (move && friction_agrees(world, first, frozen, tip, *move, kSlidingOn)) return move;
  frozen.friction = first;
  newton.emplace(world, frozen, start, tip);
  if (!newton->convex) return std::nullopt;
  return coupled(retract(world, frozen, tip, newton->move), 1);
}

}  // namespace

Prediction predict(const World& world, const StepResult& now, FrozenCoefficients& frozen) noexcept {
  const State& state = now.state;
  Prediction end;
  end.tip = state.tip;
  end.reason = "no linearization: the search begins where the sub-step does";
  const Linearization& bore = now.warm_start.linearization;
  if (bore.at != state.tip) return end;
  Energy start = without_friction(world, frozen, end.tip, bore.gradient, bore.hessian);
  start.gradient += bore.curvature;
  std::optional<NewtonStep> newton;
  end.reason = "no prediction: the stiffness is not positive";
  if (frozen.has_friction()) {
    const auto move = predict_with_friction(world, start, end.tip, frozen, newton);
    if (!move) return end;
    end.move = *move;
  } else {
    newton.emplace(world, frozen, start, end.tip, 1);
    if (!newton->convex) return end;
    end.move = newton->move;
  }
  const double length = length_of(world, frozen, end.move);
  const double radius = world.numerics.solver.predictor_trust_radius * world.annulus.clearance();
  end.reason = "no prediction: beyond the trust radius";
  if (!(length >= kResolution && length <= radius)) return end;
  end.factors = newton->factors;
  end.slope = std::abs(end.move.dot(newton->model.gradient));
  end.tip = retract(world, frozen, state.tip, end.move);
  end.valid = true;
  end.reason = "predicted";
  return end;
}

bool correct(const World& world, const FrozenCoefficients& frozen, const Prediction& end,
             const PoseVector& curvature, Iterate& iterate) noexcept {
  const Potential& potential = iterate.potential;
  if (!(std::abs(end.move.dot(potential.gradient)) <=
        world.numerics.solver.predictor_slope * end.slope))
    return false;
  iterate.iterations = 1;
  iterate.curvature = curvature;
  iterate.curvature += potential.gradient;
  if (residual(world, potential.gradient) <= kNearForce * potential.force_scale)
    final_newton_step(world, frozen.friction, frozen, end.factors.solve(potential.gradient),
                      iterate);
  return true;
}

double stiffness_determinant(const World& world, const StepResult& now) noexcept {
  const State& state = now.state;
  const Linearization& bore = now.warm_start.linearization;
  if (bore.at != state.tip) return NAN;
  const PoseVector tip(state.tip);
  const FrozenCoefficients frozen = freeze(world, state, state.command, 0);
  const NewtonStep newton(world, frozen,
                          without_friction(world, frozen, tip, bore.gradient, bore.hessian), tip, 1,
                          Pivots::as_they_are, true);
  return CoupledModel(newton, FrictionCoupling(world, frozen, tip, kSlidingOn)).determinant();
}

double contact_onset(const World& world, const State& before, const Prediction& end,
                     const Potential& potential) noexcept {
  double first = 1;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactDepth& depth = potential.depth[place];
    const ContactState& was = before.contact[place];
    if (was.closed || was.branch != 0 || depth.value == -INFINITY) continue;
    const double deeper = depth.by_pose(end.tip.t).dot(end.move);
    const auto touches = [&](double part) {
      const double d = depth.value - (1 - part) * deeper;
      return d > 0 || adhesion_force(world.laws, d, 0).branch != 0;
    };
    if (!touches(first)) continue;
    const auto apart = [&](double part) { return !touches(part); };
    first = bisect(Bracket<double>{0, first}, kBisections, apart, midpoint).fails;
  }
  return first < 1 ? first : NAN;
}

}  // namespace ferrule
