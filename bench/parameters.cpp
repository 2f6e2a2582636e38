#include "bench/parameters.hpp"

#include <algorithm>
#include <cmath>

#include "bench/random_scene.hpp"
#include "controller/statistics.hpp"
#include "sim/base/control_period.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

struct Parameter {
  const char* name;
  double SolverParameters::*real = nullptr;
  int SolverParameters::*whole = nullptr;

  double of(const SolverParameters& p) const { return real ? p.*real : p.*whole; }
  void scale(SolverParameters& p, double factor) const {
    if (real)
      p.*real *= factor;
    else
      p.*whole = static_cast<int>(std::lround(factor * p.*whole));
  }
};

using P = SolverParameters;
constexpr std::array<Parameter, 15> kSolverParameters = {
    Parameter{"force_tolerance", &P::force_tolerance},
    Parameter{"final_residual", &P::final_residual},
    Parameter{"final_move", &P::final_move},
    Parameter{"friction_tolerance", &P::friction_tolerance},
    Parameter{"max_evaluations", nullptr, &P::max_evaluations},
    Parameter{"divisible_evaluations", nullptr, &P::divisible_evaluations},
    Parameter{"reserved_evaluations", nullptr, &P::reserved_evaluations},
    Parameter{"first_travel", &P::first_travel},
    Parameter{"shortest_substep", &P::shortest_substep},
    Parameter{"snap_ratio", &P::snap_ratio},
    Parameter{"predictor_trust_radius", &P::predictor_trust_radius},
    Parameter{"predictor_slope", &P::predictor_slope},
    Parameter{"extrapolation_error", &P::extrapolation_error},
    Parameter{"extrapolation_growth", &P::extrapolation_growth},
    Parameter{"extrapolation_longest", &P::extrapolation_longest},
};

// Of the end, or of the other end of the inserted length [clearances].
double distance_of(const World& world, const State& a, const State& b) {
  const PoseVector move = PoseVector(a.tip) - b.tip;
  const double lever = b.inserted_length() + world.annulus.fibre_radius;
  return (move.length() + lever * move.t.norm()) / world.annulus.clearance();
}

void drive(const Scene& scene, Motion motion, std::uint64_t seed, std::uint64_t k,
           ParameterRow& row, std::vector<double>& errors) {
  World strict = scene.world;
  strict.numerics.extrapolation_tip = strict.numerics.extrapolation_force = 0;
  strict.numerics.solver = SolverParameters{.force_tolerance = 1e-12, .final_residual = 0};
  constexpr double period = kControlPeriod;
  const State start = draw_start(scene, seed, k);
  StepResult now(start);
  for (const Pose& hand : commands(scene, start, motion, period, seed, k)) {
    const StepResult exact = step(strict, now.state, hand, period);
    step_on(scene.world, hand, period, now);
    ++row.steps;
    row.not_converged += now.status == StepStatus::not_converged;
    row.iteration_limit += now.status == StepStatus::iteration_limit;
    row.evaluations += now.evaluations;
    row.evaluations_max = std::max(row.evaluations_max, now.evaluations);
    errors.push_back(distance_of(scene.world, now.state, exact.state));
  }
}

ParameterRow measure(ParameterRow row, const SolverParameters& parameters, std::uint64_t seed,
                     std::size_t starts, const std::vector<std::string>& scenes) {
  std::vector<double> errors;
  for (const std::string& name : scenes) {
    Scene scene = load_scene(name);
    scene.world.numerics.solver = parameters;
    for (std::size_t k = 0; k < starts; ++k)
      for (const Motion motion : {Motion::insertion, Motion::press})
        drive(scene, motion, seed, k, row, errors);
  }
  row.evaluations /= static_cast<double>(row.steps);
  row.error_p99 = quantile(errors, 0.99);
  row.error_max = quantile(errors, 1);
  return row;
}

}  // namespace

std::vector<ParameterRow> bench_parameters(std::uint64_t seed, std::size_t starts,
                                           const std::vector<std::string>& scenes,
                                           const GoOn& go_on) {
  Cases<ParameterRow> cases;
  add_case(cases, [=] { return measure({.parameter = "none"}, {}, seed, starts, scenes); });
  for (const Parameter& parameter : kSolverParameters)
    for (const double factor : {0.5, 2.0})
      add_case(cases, [=] {
        SolverParameters changed;
        parameter.scale(changed, factor);
        return measure(
            {.parameter = parameter.name, .value = parameter.of(changed), .factor = factor},
            changed, seed, starts, scenes);
      });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
