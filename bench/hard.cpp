#include "bench/hard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/analysis/hand_work.hpp"
#include "sim/base/measure.hpp"
#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"
#include "sim/terms/potential.hpp"

namespace ferrule {
namespace {

Pose pose(double x, double y, double z, double ty = 0, double tz = 0) {
  Pose p;
  p << x, y, z, ty, tz;
  return p;
}

// Runs a motion and remembers whether anything was not finite or not converged, and the work of the
// hand.
struct Run {
  const World& world;
  StepResult now;
  double dt = 1e-3;
  bool finite = true;
  long steps = 0, not_converged = 0;
  HandWork work{world, now.state};

  void to(const Pose& hand) {
    if (hand.allFinite()) work.move(now.state, hand);
    step_on(world, hand, dt, now);
    finite = finite && to_row(now.state).allFinite() && now.holder.allFinite();
    not_converged += now.status == StepStatus::not_converged;
    ++steps;
  }
  void sweep(const Pose& goal, long n) {
    const Pose from = now.state.command;
    for (long i = 1; i <= n; ++i)
      to(from + (goal - from) * (static_cast<double>(i) / static_cast<double>(n)));
  }
  // Goes far out and to `start`, a state in free air. Whether the closed motion gained energy, or
  // the fibre did not come back.
  bool gained_on_the_way_back(const State& start, long n) {
    Pose out = now.state.command;
    out[0] = start.command[0] + 100e-6;
    sweep(out, n);
    sweep(start.command, n);
    return work.gained(now.state) || (now.state.tip - start.tip).head<3>().norm() > 1e-12;
  }
};

World bare(std::vector<std::string> settings = {}) {
  settings.insert(settings.begin(), {"laws={}", "ferrule.lead_in=null",
                                     R"(tangent={"tip_nm":0,"force_uN":0})"});  // all are solved
  return load_scene("paper", settings).world;
}

// A sphere-like contact alone: adhesion (6c), rigid upright fibre, no other force.
World adhesion_alone(double lambda) {
  return bare({fmt::format("laws.adhesion={{\"form\":\"corrected\",\"work_of_adhesion_J_m2\":0.144,"
                           "\"maugis_lambda\":{}}}",
                           lambda),
               "holder.tilt_stiffness_N_m_rad=1e3", "holder.stiffness_N_m=1e8"});
}

HardRow snap_in() {
  const World world = load_scene("paper").world;
  const double c = world.annulus.clearance();
  // From free air into the bore, 400 nm from the wall, to 100 nm and on.
  const State start = at_rest(world, pose(5e-6, 400e-9 - c, 0));
  Run run{world, StepResult(start)};
  run.sweep(start.command + pose(-55e-6, 0, 0), 2000);
  run.sweep(start.command + pose(-55e-6, -300e-9, 0), 100);
  run.sweep(start.command + pose(-55e-6, -20e-6, 0), 2000);
  const bool closed = run.now.state.contact[kEnd].closed || run.now.state.contact[kSide].closed;
  const long failed = run.not_converged, steps = run.steps;
  const bool gained = run.gained_on_the_way_back(start, 4000);
  return {"snap-in from 100 nm, printed singular laws",
          run.dt,
          fmt::format("{}, {} of {} steps not converged", closed ? "in contact" : "apart", failed,
                      steps),
          closed && failed == 0 ? 0.0 : 1.0,
          0,
          run.finite,
          gained};
}

// One loop of approach and retreat loses the area between the branches.
HardRow pull_off(double lambda) {
  const World world = adhesion_alone(lambda);
  const MaugisContact& contact = *std::get<Adhesion>(world.laws.adhesion).contact;
  const MaugisCurve& curve = contact.curve;
  const double c = world.annulus.clearance();
  Run run{world, {}};
  // Five micrometres inside, tilted away from the mouth's rim: only the end touches.
  const double apart = curve.begins(1) - 2, deep = 3;
  const auto hand = [&](double depth) { return pose(-5e-6, c + depth * contact.depth, 0, -0.02); };
  run.now.state.tip = run.now.state.command = hand(apart);
  double work = 0, turned = 0;
  const long n = 20000;
  for (int way = 0; way < 2; ++way)
    for (long i = 1; i <= n; ++i) {
      const double part = static_cast<double>(i) / n;
      const Pose to = hand(way == 0 ? apart + (deep - apart) * part : deep + (apart - deep) * part);
      const double move = to[1] - run.now.state.command[1], before = run.now.holder[1];
      run.to(to);
      const double more = -0.5 * (before + run.now.holder[1]) * move;
      work += more;
      turned += std::abs(more);
    }
  double lost = 0;
  int branch = 0;
  constexpr long kFine = 400000;
  for (long i = 0; i < 2 * kFine; ++i) {
    const bool in = i < kFine;
    const double part = static_cast<double>(in ? i : 2 * kFine - 1 - i) + 0.5;
    const auto v = curve.at(apart + (deep - apart) / kFine * part, branch);
    branch = v.branch;
    lost += (in ? v.P : -v.P) * (deep - apart) / kFine;
  }
  lost *= contact.force * contact.depth;
  // Near DMT the curve does not fold, and all that was turned over comes back.
  const bool folds = std::abs(lost) > 1e-6 * contact.force * contact.depth;
  return {
      fmt::format("pull-off, lambda {:g}: loss of a loop against the area", lambda),
      run.dt,
      folds ? fmt::format("{:.5g} aJ lost, area {:.5g} aJ (error over the force and depth scales)",
                          1e18 * work, 1e18 * lost)
            : fmt::format("no fold: of {:.5g} aJ turned over all but {:.1g} came back",
                          1e18 * turned, std::abs(work) / turned),
      std::abs(work - lost) / (contact.force * contact.depth),
      1e-3,
      run.finite,
      work < -1e-6 * turned};
}

// A tilted fibre whose end rests on the lower wall; only contact and friction.
World resting_world() {
  return load_scene("paper", {"laws.van_der_waals=null", "laws.electrostatic=null",
                              "laws.capillary=null", "laws.gravity=null"})
      .world;
}

Run resting(const World& world) {
  Run run{world, {}};
  run.now.state.tip = run.now.state.command =
      pose(-20e-6, -world.annulus.clearance() - 10.1e-9, 0, 2e-3, 0);
  for (int i = 0; i < 5; ++i) run.to(run.now.state.command);
  return run;
}

HardRow stick_slip() {
  const World world = resting_world();
  Run run = resting(world);
  const double limit = friction(*friction_law(world.laws), printed::contact_radius(10e-9));
  run.sweep(run.now.state.command + pose(-0.6e-6, 0, 0), 6000);  // 0.1 um/s for 6 s
  const double force = forces(world, run.now)[Term::friction][kEnd].force.x();
  return {"slow drive at 0.1 um/s: slips at the Hurtado-Kim force",
          run.dt,
          fmt::format("{:.6g} uN, law {:.6g} uN", 1e6 * force, 1e6 * limit),
          std::abs(force / limit - 1),
          1e-3,
          run.finite};
}

HardRow creep() {
  const World world = resting_world();
  Run run = resting(world);
  const double limit = friction(*friction_law(world.laws), printed::contact_radius(10e-9));
  const Pose held = run.now.state.command + pose(-0.9 * limit / 0.5, 0, 0);
  for (int i = 0; i < 10; ++i) run.to(held);
  const double from = run.now.state.tip[0];
  for (int i = 0; i < 100000; ++i) run.to(held);
  const double nm = 1e9 * std::abs(run.now.state.tip[0] - from);
  return {"creep under 0.9 of the friction force, 100 s",
          run.dt,
          fmt::format("{:.2g} nm (error in nm)", nm),
          nm,
          1e-6,
          run.finite};
}

HardRow jam() {
  const World world = bare({"holder.tilt_stiffness_N_m_rad=1e-6", "holder.stiffness_N_m=5"});
  const double tilt = 12e-3;
  const State start = at_rest(world, pose(1e-6, 0, 0, tilt, 0));
  Run run{world, StepResult(start)};
  run.sweep(start.command + pose(-200e-6, 0, 0), 20000);
  // It turns as it goes deeper, so that at every depth it touches at two points: depth tilt = 2 c.
  const double depth = run.now.state.inserted_length();
  const bool two = run.now.state.contact[kEnd].closed && run.now.state.contact[kSide].closed;
  const double tilt_now = run.now.state.tip[3];
  const bool gained = run.gained_on_the_way_back(start, 20000);
  return {"two-point jam of a tilted fibre",
          run.dt,
          fmt::format("{} at {:.4g} um and {:.4g} mrad", two ? "two points" : "free", 1e6 * depth,
                      1e3 * tilt_now),
          two ? std::abs(depth * tilt_now / (2 * world.annulus.clearance()) - 1) : 1.0,
          5e-2,
          run.finite,
          gained};
}

HardRow refused(const std::string& bore, const std::string& fibre) {
  std::string said = "accepted";
  try {
    load_scene("paper", {"ferrule.bore_diameter_um=" + bore, "fibre.diameter_um=" + fibre});
  } catch (const BadInput&) {
    said = "refused";
  }
  return {"fibre of " + fibre + " um in a bore of " + bore + " um",
          kNan,
          said,
          said == "refused" ? 0.0 : 1.0,
          0,
          true};
}

// Any step size: an insertion that starts misaligned ends at the same place.
HardRow step_size(double dt) {
  const World world = load_scene("paper", {"laws.capillary=null", "laws.electrostatic=null"}).world;
  const State start = at_rest(world, pose(5e-6, -1e-6, 0.3e-6, 5e-4, 0));
  const Pose goal = pose(-10e-6, 0, 0, 5e-4, 0);
  constexpr double duration = 1.0;
  const auto end = [&](double period) {
    Run run{world, StepResult(start)};
    run.dt = period;
    run.sweep(goal, std::lround(duration / period));
    return run;
  };
  Run run = end(dt);
  const double nm = 1e9 * (run.now.state.tip - end(1e-4).now.state.tip).head<3>().norm();
  const bool gained =
      run.gained_on_the_way_back(start, std::min(20000L, std::lround(duration / dt)));
  return {"insertion, step size",
          dt,
          fmt::format("{:.2g} nm from that at 0.1 ms, {} of {} not converged (error in nm)", nm,
                      run.not_converged, run.steps),
          nm,
          5,
          run.finite,
          gained};
}

HardRow drift() {
  const World world = load_scene("paper").world;
  Run run{world, StepResult(at_rest(world, pose(5e-6, -1e-6, 0, 5e-4, 0)))};
  run.sweep(pose(-10e-6, 0, 0, 5e-4, 0), 2000);
  const Pose held = run.now.state.command;
  for (int i = 0; i < 10; ++i) run.to(held);
  const Pose from = run.now.state.tip;
  for (long i = 0; i < 10'000'000; ++i) step_on(world, held, 1e-3, run.now);
  const double nm = 1e9 * (run.now.state.tip - from).head<3>().norm();
  return {
      "1e7 steps at rest in contact", 1e-3, fmt::format("{:.2g} nm (error in nm)", nm), nm, 1e-6,
      run.now.state.tip.allFinite()};
}

// Corrected surface laws at an eccentricity within 1e-9 of the clearance, smooth surfaces.
HardRow eccentricity_near_clearance() {
  const Annulus smooth = {62.5e-6, 63e-6};
  const VanDerWaals vdw = {3.67e-19};
  const Electrostatic el = {0.1};
  bool finite = true;
  double worst = 0;
  for (double part = 1e-1; part > 0.9e-9; part *= 0.1) {
    const double h = part * smooth.clearance();
    const LineForce a = van_der_waals(vdw, smooth, h), b = electrostatic(el, smooth, h);
    finite = finite && std::isfinite(a.force) && std::isfinite(a.slope) && std::isfinite(b.force) &&
             std::isfinite(b.slope) && a.force < 0 && b.force < 0;
    if (h < 0.1e-9) continue;  // held from the interatomic distance on
    const double c = smooth.clearance(), e = c - h;
    const double expected =
        -3.67e-19 * 62.5e-6 * c * e / (2 * std::pow(h, 2.5) * std::pow(c + e, 2.5));
    worst = std::max(worst, std::abs(a.force / expected - 1));
  }
  return {"eccentricity to 1 - 1e-9 of the clearance",
          kNan,
          "finite and attractive",
          worst,
          1e-10,
          finite};
}

HardRow forces_apart() {
  // A holder of 1e-3 N/m and a wall of 1e4 N/m, forces of tenths of a micronewton and a piconewton.
  const World world = bare({"holder.stiffness_N_m=0.001", "holder.tilt_stiffness_N_m_rad=1e-3",
                            "laws.meniscus={\"form\":\"corrected\",\"surface_tension_N_m\":1e-9,"
                            "\"contact_angle_deg\":0}"});
  const State start = at_rest(world, pose(2e-6, 0, 0));
  Run run{world, StepResult(start)};
  run.sweep(start.command + pose(-52e-6, 0, 0), 100);
  run.sweep(start.command + pose(-52e-6, 400e-6, 0), 400);
  const double push = run.now.holder[1], pull = forces(world, run.now)[Term::meniscus][0].force.x();
  const Wrench left = forces(world, run.now).sum(run.now.state.tip) - run.now.holder;
  const bool gained = run.gained_on_the_way_back(start, 400);
  return {"forces 1e6 apart in one scene",
          run.dt,
          fmt::format("wall {:.3g} uN, meniscus {:.3g} uN, imbalance along x {:.2g} uN",
                      -1e6 * push, 1e6 * pull, 1e6 * std::abs(left[0])),
          std::abs(left[0] / pull),
          1e-3,
          run.finite,
          gained};
}

HardRow bad_device() {
  const World world = load_scene("paper").world;
  const State start = at_rest(world, pose(5e-6, -1e-6, 0));
  Run run{world, StepResult(start)};
  run.sweep(pose(-10e-6, 0, 0), 1000);
  const State before = run.now.state;
  int wrong = 0;
  Pose hand = before.command;
  hand[1] = NAN;
  StepResult r = step(world, before, hand, 1e-3);
  wrong += r.status != StepStatus::bad_command || to_row(r.state) != to_row(before);
  r = step(world, before, before.command, -1e-3);
  wrong += r.status != StepStatus::bad_command || to_row(r.state) != to_row(before);
  run.to(before.command + pose(0, 1e-3, -1e-3));  // a jump of 1.4 mm, 0.35 m in the hand
  for (int i = 0; i < 1000; ++i) run.to(run.now.state.command);  // a stall
  wrong += run.now.state.tip.segment<2>(1).norm() > world.annulus.clearance() + 50e-9;
  run.to(before.command);
  wrong += (run.now.state.tip - before.tip).head<3>().norm() > 2e-6;
  const bool gained = run.gained_on_the_way_back(start, 1000);
  return {"NaN, time running backwards, jump and stall of a device",
          1e-3,
          fmt::format("{} of 4 answered wrongly", wrong),
          static_cast<double>(wrong),
          0,
          run.finite,
          gained};
}

}  // namespace

std::vector<HardRow> bench_hard(const GoOn& go_on) {
  Cases<HardRow> cases;
  add_case(cases, snap_in);
  for (const double lambda : {0.01, 0.3, 1.0, 4.0, 20.0, 100.0})
    add_case(cases, [lambda] { return pull_off(lambda); });
  add_case(cases, stick_slip);
  add_case(cases, creep);
  add_case(cases, jam);
  add_case(cases, [] { return refused("125", "125"); });
  add_case(cases, [] { return refused("125.5", "125.7"); });
  for (const double dt : {1e-6, 1e-5, 1e-3, 1e-2, 1e-1})
    add_case(cases, [dt] { return step_size(dt); });
  add_case(cases, drift);
  add_case(cases, eccentricity_near_clearance);
  add_case(cases, forces_apart);
  add_case(cases, bad_device);
  return rows_of(cases, go_on);
}

}  // namespace ferrule
