#include "bench/stepping.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "bench/reference.hpp"
#include "sim/base/measure.hpp"
#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"
#include "sim/terms/potential.hpp"

namespace ferrule {
namespace {

constexpr double kFineStep = 1e-6;  // [s]

struct Case {
  std::string name;
  World world;
  State start;
  std::function<Pose(double)> hand;
  double duration;            // [s]
  std::vector<double> times;  // where poses are compared [s]
  std::vector<Pose> exact;
};

Wrench felt(const World& world, const Pose& tip, const Pose& hand) {
  return world.holder.stiffness * (tip - hand);
}

// Errors of poses at the case's times.
void compare(const Case& c, const std::vector<Pose>& poses, SteppingRow& row) {
  double largest = 0, force = 0;
  row.tip_error_nm = 0;
  for (std::size_t i = 0; i < c.times.size(); ++i) {
    const Pose hand = c.hand(c.times[i]);
    const Vector3d exact = felt(c.world, c.exact[i], hand).head<3>();
    largest = std::max(largest, exact.norm());
    force = std::max(force, (felt(c.world, poses[i], hand).head<3>() - exact).norm());
    const double error = 1e9 * (poses[i] - c.exact[i]).head<3>().norm();
    row.tip_error_nm = std::isfinite(error) ? std::max(row.tip_error_nm, error) : kNan;
    if (!std::isfinite(error)) break;
  }
  row.force_error_relative = std::isfinite(row.tip_error_nm) ? force / largest : kNan;
}

SteppingRow simulate(const Case& c, const std::string& method, double dt) {
  SteppingRow row{method, c.name, dt, 0, 0, 0, 0};
  const auto steps = std::lround(c.duration / dt);
  std::vector<Pose> hand;  // the input: not what is measured
  for (long n = 1; n <= steps; ++n) hand.push_back(c.hand(static_cast<double>(n) * dt));
  std::vector<Pose> poses;
  long iterations = 0;
  const auto run = [&](bool keep_poses) {
    StepResult r(c.start);
    std::size_t next = 0;
    for (long n = 1; n <= steps; ++n) {
      const double t = static_cast<double>(n) * dt;
      step_on(c.world, hand[static_cast<std::size_t>(n - 1)], dt, r);
      if (!keep_poses) continue;
      iterations += r.iterations;
      row.not_converged += r.status != StepStatus::ok;
      row.rejected += r.rejected;
      if (next < c.times.size() && t >= c.times[next] - 1e-9 * dt) {
        poses.push_back(r.state.tip);
        ++next;
      }
    }
    keep(r.state.tip);
  };
  run(true);
  row.newton_iterations = static_cast<double>(iterations) / static_cast<double>(steps);
  compare(c, poses, row);
  row.ns_per_step = nanoseconds_per_call([&](long) { run(false); }) / static_cast<double>(steps);
  row.us_per_simulated_s = 1e-3 * row.ns_per_step / dt;
  return row;
}

// The naive baseline: q += dt dq/dt with the rates at the step's start.
SteppingRow explicit_euler(const Case& c, double dt) {
  SteppingRow row{"explicit_euler", c.name, dt, 0, 0, 0, 0};
  const auto steps = std::lround(c.duration / dt);
  std::vector<Pose> poses;
  State state = c.start;
  std::size_t next = 0;
  const auto begin = std::chrono::steady_clock::now();
  long taken = 0;
  for (long n = 1; n <= steps && state.tip.allFinite(); ++n, ++taken) {
    const double t = static_cast<double>(n) * dt;
    const Pose hand = c.hand(t - dt);
    const FrozenCoefficients still = freeze(c.world, state, hand, 0);
    const Potential there(c.world, still, state.tip);
    // At the step's start drag has no force, and what it adds to the Hessian is its damping divided
    // by dt.
    const Matrix5 damping =
        Potential(c.world, freeze(c.world, state, hand, dt), state.tip).hessian.full() -
        there.hessian.full();
    state.tip -= damping.llt().solve(there.gradient.full());
    if (state.tip.head<3>().norm() > 1) state.tip.setConstant(kNan);
    if (next < c.times.size() && t >= c.times[next] - 1e-9 * dt) {
      poses.push_back(state.tip);
      ++next;
    }
  }
  const double ns =
      std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
  poses.resize(c.times.size(), Pose::Constant(kNan));
  row.ns_per_step = ns / static_cast<double>(taken);
  row.us_per_simulated_s = 1e-3 * row.ns_per_step / dt;
  compare(c, poses, row);
  return row;
}

std::vector<double> every(double period, double duration) {
  std::vector<double> times;
  for (long n = 1; n <= std::lround(duration / period); ++n)
    times.push_back(static_cast<double>(n) * period);
  return times;
}

Case free_flight() {
  Case c{"free flight", load_scene("paper").world, {}, {}, 1, every(0.1, 1), {}};
  Pose from = Pose::Zero();
  from[0] = 300e-6;
  c.start = at_rest(c.world, from);
  const Pose hand = c.start.command;
  c.hand = [hand](double t) {
    Pose h = hand;
    h[0] -= 8e-6 * t;
    h[1] += 2e-6 * std::sin(6 * t);
    return h;
  };
  for (const double t : c.times) c.exact.push_back(c.hand(t) + c.world.holder.sag);
  return c;
}

// A tilted fibre wedged between end and side, corrected laws, pushed in through adhesive. Without a
// reference yet.
Case wedged(const std::string& name, const std::string& friction) {
  const World world =
      load_scene("paper", {"roughness_nm=5", "laws.van_der_waals.form=corrected",
                           "laws.electrostatic.form=corrected", "laws.gravity.form=corrected",
                           "laws.capillary=null", "laws.adhesion.form=corrected", friction,
                           "ferrule.lead_in=null",
                           "laws.drag={\"form\":\"corrected\",\"viscosity_Pa_s\":0.5}"})
          .world;
  Case c{name, world, {}, {}, 0.5, every(0.01, 0.5), {}};
  const double clearance = world.annulus.clearance(), length = 50e-6;
  c.start.tip << -length, clearance, 0, -2 * clearance / length, 0;
  c.start.command = c.start.tip;
  const auto hand = [start = c.start.tip](double t) {
    Pose h = start;
    const double p = std::min(1.0, t / 0.4), s = p * p * (3 - 2 * p);
    h[0] -= 4e-6 * s;
    h[1] += 1.5e-6 * s;
    h[3] -= 1e-3 * s;
    return h;
  };
  c.hand = hand;
  // Closed and at rest before it moves.
  StepResult now(c.start);
  for (int n = 0; n < 2000; ++n) step_on(world, hand(0), 1e-3, now);
  c.start = now.state;
  c.start.time = 0;
  return c;
}

Case two_contacts() {
  Case c = wedged("two contacts in adhesive", "laws.friction=null");
  c.exact = reference_trajectory(c.world, c.start, c.hand, c.times);
  return c;
}

// The stuck state of friction is no differential equation: the reference is the same method in
// steps of 1 us, each of them solved.
Case two_contacts_with_friction() {
  Case c = wedged("two contacts with friction", "laws.friction.form=corrected");
  World world = c.world;
  world.numerics.extrapolation_tip = 0;
  StepResult now(c.start);
  long n = 0;
  for (const double time : c.times) {
    for (; static_cast<double>(n) * kFineStep < time - 0.5 * kFineStep; ++n)
      step_on(world, c.hand(static_cast<double>(n + 1) * kFineStep), kFineStep, now);
    c.exact.push_back(now.state.tip);
  }
  return c;
}

// An elastic fibre in air, plucked by its holder.
Case vibration() {
  const std::string holder =
      R"(holder={"type": "elastic_fibre", "free_length_mm": 10, "gripper_stiffness_N_m": 1000})";
  const World world =
      load_scene("paper", {"laws={}", "fibre.density_kg_m3=2200", "fibre.young_GPa=72",
                           "dynamics=inertial", "start.distance_um=400", holder})
          .world;
  Case c{"vibration", world, {}, {}, 0.02, every(0.001, 0.02), {}};
  Pose from = Pose::Zero();
  from[0] = 400e-6;
  c.start = at_rest(world, from);
  c.hand = [hand = c.start.command](double t) {
    Pose h = hand;
    const double p = std::min(1.0, t / 4e-3);
    h[1] += 10e-6 * p * p * (3 - 2 * p);
    return h;
  };
  c.exact = reference_trajectory(world, c.start, c.hand, c.times);
  return c;
}

}  // namespace

std::vector<SteppingRow> bench_stepping(const GoOn& go_on) {
  // A case and its reference are made when they are first needed: some take seconds.
  std::optional<Case> wedge, rubbing, plucked;
  const auto made = [](std::optional<Case>& c, Case (*make)()) -> Case& {
    if (!c) c = make();
    return *c;
  };
  Cases<SteppingRow> cases;
  add_case(cases, [] { return simulate(free_flight(), "quasi_static", 1e-3); });
  for (const double dt : {1e-2, 5e-3, 1e-3, 1e-4})
    add_case(cases, [&, dt] { return simulate(made(wedge, two_contacts), "backward_euler", dt); });
  for (const double dt : {1e-2, 1e-3, 1e-4})
    add_case(cases, [&, dt] {
      return simulate(made(rubbing, two_contacts_with_friction), "backward_euler", dt);
    });
  // The naive baseline, from the step of the simulator down to one that it survives.
  cases.push_back([&](std::vector<SteppingRow>& rows) {
    for (double dt = 1e-3; dt > 1e-8; dt /= 10) {
      rows.push_back(explicit_euler(made(wedge, two_contacts), dt));
      if (std::isfinite(rows.back().tip_error_nm) && rows.back().tip_error_nm < 100) break;
    }
  });
  for (const Integrator method : {Integrator::backward_euler, Integrator::bdf2})
    for (const double dt : {1e-4, 1e-5, 1e-6})
      add_case(cases, [&, method, dt] {
        Case& c = made(plucked, vibration);
        c.world.numerics.integrator = method;
        return simulate(c, method == Integrator::bdf2 ? "bdf2" : "backward_euler", dt);
      });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
