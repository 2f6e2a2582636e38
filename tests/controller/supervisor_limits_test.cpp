// A supervisor keeps its limits whatever is commanded and observed.
#include "controller/campaign.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/watch.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/demo_limits.hpp"

namespace ferrule {
namespace {

// What a controller may do wrong, seeded.
class Adversary : public Controller {
 public:
  enum Kind { random, constant, not_finite, alternating, huge, tilting, sideways };
  static constexpr int kKinds = 7;

  Adversary(int kind, std::uint64_t seed, const SupervisorLimits& limits)
      : kind_(kind), chance_(seed, 0, Draw::operator_hand), limits_(limits) {}

  HandTwist command(const Observation&) noexcept override {
    ++n_;
    const double speed = limits_.speed, t = 1e-3 * n_;
    HandTwist v = HandTwist::Zero();
    v[0] = -speed;
    switch (kind_) {
      case random:
        if (n_ % 50 == 1) {
          held_ = 2 * speed * any();
          held_[0] -= speed;
          held_.tail<2>() /= limits_.lever;
        }
        return held_;
      case not_finite:
        if (chance_.uniform() < 5e-4) v[n_ % 5] = n_ % 2 ? NAN : INFINITY;
        return v;
      case alternating:
        v[0] = (n_ / 100) % 2 ? 5 * speed : -8 * speed;
        return v;
      case huge:
        v = 1e300 * any();
        v[0] = -std::abs(v[0]);
        return v;
      case tilting:
        v.tail<2>() << 30 * speed / limits_.lever * std::sin(t),
            3 * speed / limits_.lever * std::cos(0.7 * t);
        return v;
      case sideways:
        v.head<3>() = speed * Eigen::Vector3d(-0.4, 0.7 * std::cos(t), 0.7 * std::sin(t));
        return v;
      default:
        return v;
    }
  }

 private:
  HandTwist any() {
    HandTwist v;
    for (double& x : v) x = 2 * chance_.uniform() - 1;
    return v;
  }

  int kind_, n_ = 0;
  RandomStream chance_;
  SupervisorLimits limits_;
  HandTwist held_ = HandTwist::Zero();
};

// Tilts as motions of the lever.
HandTwist levered(HandTwist v, const SupervisorLimits& limits) {
  v.tail<2>() *= limits.lever;
  return v;
}

// |u| that a force limit stops where nothing is felt, [m/s]: the larger root of
// s^2 / 2a + s (T / 2 + l) = F_b / k, the sensor being late by l.
double stoppable(const SupervisorLimits& limits) {
  const double late = limits.period * (1 / limits.follows - 0.5), a = limits.acceleration;
  return std::sqrt(a * a * late * late + 2 * a * limits.brakes_for() / limits.stiffness) - a * late;
}

struct Extremes {
  // Relative to the limits; `change` where force does not win.
  double speed = 0, with_tilt = 0, change = 0;
  bool always_finite = true, stops_are_whole = true;
};

// Looks at one command after `before`, felt force f; `hidden`: what the sensor's lag and errors may
// hide of the true one.
void look(const SupervisorLimits& limits, const Eigen::Vector3d& force, const HandTwist& before,
          const HandTwist& now, Extremes& e, double hidden = 0) {
  e.always_finite &= now.allFinite();
  e.speed = std::max(e.speed, now.head<3>().norm() / limits.speed);
  e.with_tilt = std::max(e.with_tilt, now.norm() / stoppable(limits));
  const double most = limits.acceleration * limits.period;
  const double worth = limits.stiffness * stoppable(limits) * limits.period + hidden;
  if (force.norm() + worth < limits.force) {
    e.change = std::max(e.change, (now - before).norm() / most);
    return;
  }
  // Near the limit it may stop at once, but not speed up; and what strains further could exceed the
  // limit by nothing.
  e.change = std::max(e.change, (now.norm() - before.norm()) / most);
  const Eigen::Vector3d along = force.normalized();
  HandTwist straining = now;
  straining.head<3>() -= std::max(0.0, along.dot(now.head<3>())) * along;
  const double next = force.norm() + limits.stiffness * straining.norm() * limits.period;
  e.stops_are_whole &=
      straining.norm() <= 1e-12 * limits.speed || next <= limits.force * (1 + 1e-9);
}

TEST(Supervisor, KeepsSpeedAndAccelerationWhateverIsCommandedAndFelt) {
  const SupervisorLimits limits = testing::demo_limits();
  for (std::uint64_t seed = 0; seed < 140; ++seed) {
    RandomStream chance(seed, 1, Draw::start);
    Supervisor supervisor(
        std::make_unique<Adversary>(static_cast<int>(seed % Adversary::kKinds), seed, limits),
        limits);
    HandTwist before = HandTwist::Zero();
    Extremes extremes;
    Observation observation{HandWrench::Zero(), 0, 0};
    for (int n = 0; n < 3000; ++n) {
      // A force that wanders, jumps beyond the limit, and sometimes cannot be read.
      for (int i = 0; i < 3; ++i) observation.wrench[i] += 0.02 * limits.force * chance.normal();
      if (chance.uniform() < 0.01) observation.wrench *= 3 * chance.uniform();
      if (observation.wrench.norm() > 3 * limits.force) observation.wrench.setZero();
      observation.time = n * limits.period;
      Observation read = observation;
      if (seed % 3 == 0 && chance.uniform() < 1e-3) read.wrench[n % 5] = NAN;
      const HandTwist now = levered(supervisor.command(read), limits);
      if (read.wrench.allFinite())
        look(limits, observation.wrench.head<3>(), before, now, extremes);
      else
        EXPECT_LE((now - before).norm(), limits.acceleration * limits.period * (1 + 1e-9));
      before = now;
    }
    EXPECT_TRUE(extremes.always_finite) << seed;
    EXPECT_TRUE(extremes.stops_are_whole) << seed;
    EXPECT_LE(extremes.speed, 1 + 1e-12) << seed;
    EXPECT_LE(extremes.with_tilt, 1 + 1e-12) << seed;
    EXPECT_LE(extremes.change, 1 + 1e-9) << seed;
  }
}

struct Closed {
  Extremes extremes;
  double force = 0;       // largest, over the limit [-]
  double caused = 0;      // the same without what it rose by more than the motion explains
  double snapped = 0;     // the most it rose so in one period, over the limit
  std::size_t snaps = 0;  // periods in which it did
  double misread = 0;     // the most the sensor read too little, over the limit
  Outcome outcome{};
};

// A supervised adversary in the simulator, feeling what the scene's sensor reads.
Closed run(const Scene& scene, int kind, std::uint64_t seed) {
  const Scaling scaling = scene_scaling(scene);
  const SupervisorLimits limits = supervisor_limits(scene);
  Supervisor supervisor(std::make_unique<Adversary>(kind, seed, limits), limits);
  StepResult result(draw_start(scene, seed, static_cast<std::uint64_t>(kind)));
  const State& state = result.state;
  InsertionWatch watch(scene, state);
  HandPose pose = scaling.motion_to_hand(state.command);
  ForceSensor sensor(scene.sensor, seed, static_cast<std::uint64_t>(kind));
  HandTwist v = HandTwist::Zero();
  HandWrench rest, read_rest;
  double before = 0, unexplained = 0;
  const double lag = limits.period * (1 / limits.follows - 1);
  Closed closed;
  for (int n = 0;; ++n) {
    pose += limits.period * v;
    step_on(scene.world, scaling.motion_to_tip(pose), n == 0 ? 0 : limits.period, result);
    const HandWrench wrench = scaling.wrench_to_hand(result.holder);
    const HandWrench read = scaling.wrench_to_hand(sensor.read(result.holder, limits.period));
    if (n == 0) {
      rest = wrench;
      read_rest = read;
    }
    const Eigen::Vector3d felt = (read - read_rest).head<3>();
    const Eigen::Vector3d force = (wrench - rest).head<3>();
    const HandTwist moved = levered(v, limits);
    const double rise = force.norm() - before - limits.stiffness * moved.norm() * limits.period;
    if (rise > 1e-6 * limits.force) {
      ++closed.snaps;
      closed.snapped = std::max(closed.snapped, rise / limits.force);
      unexplained += rise;
    }
    before = force.norm();
    closed.misread = std::max(closed.misread, (before - felt.norm()) / limits.force);
    closed.force = std::max(closed.force, before / limits.force);
    closed.caused = std::max(closed.caused, (before - unexplained) / limits.force);
    if (const auto outcome = watch.after(result)) {
      closed.outcome = *outcome;
      return closed;
    }
    v = supervisor.command({read - read_rest, hand_depth(pose), n * limits.period});
    look(limits, felt, moved, levered(v, limits), closed.extremes,
         limits.misread + limits.stiffness * stoppable(limits) * lag);
    if (supervisor.supervision()->gave_up) {
      closed.outcome = Outcome::gave_up;
      return closed;
    }
  }
}

Scene variant(std::vector<std::string> settings) {
  for (const char* each :
       {"limits.time_s=8", "start.distance_um=20", "start.lateral_sd_um=6", "success.depth_um=20"})
    settings.push_back(each);
  return load_scene("demo", settings);
}

const std::vector<std::string> kCorrected = {
    "laws.van_der_waals.form=corrected", "laws.electrostatic.form=corrected",
    "laws.gravity.form=corrected", "laws.adhesion.form=corrected", "laws.friction.form=corrected"};
const char* const kSoftHolder =
    "holder={\"type\":\"elastic_fibre\",\"free_length_mm\":20,\"gripper_stiffness_N_m\":1}";

TEST(SupervisorAtLength, KeepsTheForceWithinTheLimitInTheSimulator) {
  std::vector<std::string> rough = kCorrected, soft = kCorrected;
  rough.push_back("roughness_nm=20");
  soft.push_back("roughness_nm=20");
  soft.push_back(kSoftHolder);
  const Scene wide = load_scene("demo", {"limits.time_s=8"});
  for (const Scene& scene : {wide, variant({}), variant(rough), variant(soft)})
    for (int kind = 0; kind < Adversary::kKinds; ++kind)
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const Closed c = run(scene, kind, seed);
        EXPECT_LE(c.force, 1) << kind << " " << seed;
        EXPECT_LE(c.caused, 0.9 + 1e-4) << kind << " " << seed;  // what it brakes for
        EXPECT_LE(c.snapped, 0.02) << kind << " " << seed;
        EXPECT_LE(c.extremes.speed, 1 + 1e-12);
        EXPECT_LE(c.extremes.with_tilt, 1 + 1e-12);
        EXPECT_LE(c.extremes.change, 1 + 1e-9);
        EXPECT_TRUE(c.extremes.always_finite && c.extremes.stops_are_whole);
      }
}

// The true force keeps the limit, and not only the one that is read: the margin covers what the
// sensor's lag hides, and its noise and bias.
TEST(Supervisor, KeepsTheTrueForceWithinTheLimitWhateverTheSensor) {
  const std::vector<std::string> quick = {"limits.time_s=5", "start.distance_um=20",
                                          "success.depth_um=20", "ferrule.lead_in=null"};
  const std::vector<std::vector<std::string>> sensors = {
      {},
      {"sensor.noise_uN=4", "sensor.bias_uN=8", "sensor.bandwidth_Hz=50"},
      {"sensor.noise_uN=0", "sensor.bias_uN=0"},
      {"sensor.noise_uN=0", "sensor.bias_uN=0", "sensor.bandwidth_Hz=5"},
      {"sensor.noise_uN=0", "sensor.bias_uN=0", "sensor.bandwidth_Hz=100000"}};
  double largest = 0, misread = 0;
  for (const std::vector<std::string>& sensor : sensors) {
    std::vector<std::string> settings = quick;
    settings.insert(settings.end(), sensor.begin(), sensor.end());
    const Scene scene = load_scene("bench", settings);
    for (int kind = 0; kind < Adversary::kKinds; ++kind)
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const Closed c = run(scene, kind, seed);
        EXPECT_LE(c.extremes.speed, 1 + 1e-12);
        EXPECT_LE(c.extremes.with_tilt, 1 + 1e-12);
        EXPECT_LE(c.extremes.change, 1 + 1e-9);
        EXPECT_TRUE(c.extremes.always_finite && c.extremes.stops_are_whole);
        EXPECT_LE(c.force, 1) << kind << " " << seed;
        EXPECT_NE(c.outcome, Outcome::force_limit) << kind << " " << seed;
        largest = std::max(largest, c.force);
        misread = std::max(misread, c.misread);
      }
  }
  EXPECT_GT(largest, 0.8);  // it was braked for
  EXPECT_GT(misread, 0.1);  // and a sensor did err by more than the margin
}

// Without contact the force rises by k per metre, and a sensor of first order follows: the bound on
// what it has not shown is exact where the hand goes straight on.
TEST(Supervisor, StopsBeforeTheLimitBehindASensorThatLags) {
  SupervisorLimits limits = testing::demo_limits();
  for (const double follows : {1.0, 0.5, 0.1, 0.01}) {
    limits.follows = follows;
    Supervisor supervisor(std::make_unique<ConstantVelocity>(2 * limits.speed), limits);
    Observation observation{HandWrench::Zero(), 0, 0};
    double force = 0, shown = 0;
    const Supervision& done = *supervisor.supervision();
    for (int n = 0; n < 20000 && !done[Intervention::retreat]; ++n) {
      observation.wrench[0] = shown;
      observation.time = n * limits.period;
      force -= limits.stiffness * limits.period * supervisor.command(observation)[0];
      shown += follows * (force - shown);
    }
    EXPECT_LE(force, limits.brakes_for() * (1 + 1e-3)) << follows;
    EXPECT_GT(force, 0.3 * limits.brakes_for()) << follows;
  }
}

// So does a tilt, which counts by what it strains: it makes no motion stiffer.
TEST(Supervisor, BrakesForTheStiffestMotionOfTheHolder) {
  for (const char* gripper :
       {"", "holder.gripper_stiffness_N_m=20", "holder.gripper_stiffness_N_m=1e6"}) {
    const Scene scene = load_scene(
        "bench", *gripper ? std::vector<std::string>{gripper} : std::vector<std::string>{});
    const SupervisorLimits limits = supervisor_limits(scene);
    const Scaling scaling = scene_scaling(scene);
    const Matrix5& k = scene.world.holder.stiffness;
    EXPECT_CLOSE(limits.stiffness, k(0, 0) * scaling.force / scaling.motion, 1e-12) << gripper;
    const double lever = limits.lever / scaling.motion;
    EXPECT_CLOSE(k(3, 3) / (lever * lever), 0.5 * k(0, 0), 1e-9) << gripper;
  }
}

TEST(Supervisor, SaysWhatItCannotHold) {
  const Scene bench = load_scene("bench"),
              blind = load_scene("bench", {"sensor.noise_uN=10", "sensor.bias_uN=10"});
  EXPECT_EQ(cannot_hold(supervisor_limits(bench)), "");
  const std::string why = cannot_hold(supervisor_limits(blind));
  EXPECT_NE(why.find("cannot be held"), std::string::npos) << why;
}

// What a late hand goes on by is a force by the holder's stiffness.
TEST(Supervisor, SaysThatALateHandMayExceedTheLimitWhereTheHolderIsStiff) {
  for (const char* hand : {"hand.delay_ms=5", "hand.smoothing_ms=5"}) {
    const Scene stiff = load_scene("bench", {hand}),
                soft = load_scene("bench", {hand, "holder.gripper_stiffness_N_m=20"});
    EXPECT_NE(cannot_hold(supervisor_limits(stiff)).find("late, and goes on for 5 ms"),
              std::string::npos);
    EXPECT_EQ(cannot_hold(supervisor_limits(soft)), "");
    const double speed = scene_scaling(soft).motion * soft.limits.speed;
    const Campaign straight{
        &soft, supervised(controller_maker(ConstantVelocity(speed)), supervisor_limits(soft))};
    const auto results = run_campaigns({straight}, 3, 20, 0, {});
    for (const TrialResult& trial : results.front()) EXPECT_NE(trial.outcome, Outcome::force_limit);
  }
}

// Perfectly smooth surfaces snap together and pull the fibre in with more than any limit. That is
// no motion of the hand's; what the hand adds stays within the limit.
TEST(Supervisor, AddsNothingToTheForceOfASnap) {
  std::vector<std::string> smooth = kCorrected;
  for (const char* each :
       {"roughness_nm=2", "limits.time_s=3", "start.distance_um=5", "start.lateral_sd_um=1"})
    smooth.push_back(each);
  std::size_t snaps = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const Closed c = run(load_scene("demo", smooth), Adversary::constant, seed);
    snaps += c.snaps;
    EXPECT_LE(c.caused, 0.9 + 1e-4);
    EXPECT_LE(c.extremes.change, 1 + 1e-9);
  }
  EXPECT_GT(snaps, 0u);
}

}  // namespace
}  // namespace ferrule
