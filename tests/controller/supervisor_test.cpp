#include "controller/supervisor.hpp"

#include "capture/replay.hpp"
#include "controller/campaign.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/random.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

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

SupervisorLimits demo_limits() {
  const Scene scene = load_scene("demo");
  return supervisor_limits(scene, scene_scaling(scene));
}

// Tilts as motions of the lever.
HandTwist levered(HandTwist v, const SupervisorLimits& limits) {
  v.tail<2>() *= limits.lever;
  return v;
}

struct Extremes {
  double speed = 0, change = 0;  // relative to the limits; `change` where force does not win
  bool always_finite = true, stops_are_whole = true;
};

// Looks at one command after `before`, felt force f.
void look(const SupervisorLimits& limits, const Eigen::Vector3d& force, const HandTwist& before,
          const HandTwist& now, Extremes& e) {
  e.always_finite &= now.allFinite();
  e.speed = std::max(e.speed, now.norm() / limits.speed);
  const double most = limits.acceleration * limits.period;
  const double worth = limits.stiffness * limits.speed * limits.period;
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
  const SupervisorLimits limits = demo_limits();
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
  const SupervisorLimits limits = supervisor_limits(scene, scaling);
  Supervisor supervisor(std::make_unique<Adversary>(kind, seed, limits), limits);
  State state = draw_start(scene, seed, static_cast<std::uint64_t>(kind));
  InsertionWatch watch(scene, state);
  HandPose pose = scaling.motion_to_hand(state.command);
  ForceSensor sensor(scene.sensor, seed, static_cast<std::uint64_t>(kind));
  HandTwist v = HandTwist::Zero();
  HandWrench rest, read_rest;
  double before = 0, unexplained = 0;
  Closed closed;
  for (int n = 0;; ++n) {
    pose += limits.period * v;
    const StepResult result =
        step(scene.world, state, scaling.motion_to_tip(pose), n == 0 ? 0 : limits.period);
    state = result.state;
    const HandWrench wrench = scaling.wrench_to_hand(result.forces.holder);
    const HandWrench read =
        scaling.wrench_to_hand(sensor.read(result.forces.holder, limits.period));
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
    look(limits, felt, moved, levered(v, limits), closed.extremes);
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

TEST(Supervisor, KeepsTheForceWithinTheLimitInTheSimulator) {
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
        EXPECT_LE(c.extremes.change, 1 + 1e-9);
        EXPECT_TRUE(c.extremes.always_finite && c.extremes.stops_are_whole);
      }
}

// What is promised with a sensor that errs: the force it reads keeps the limit as above, so the
// true one exceeds it by no more than is misread at that moment. `bench`'s sensor, noise, drift and
// lag together, is not that bad: there the true force itself keeps the limit.
TEST(Supervisor, KeepsTheTrueForceWithinTheLimitBarWhatTheSensorMisreads) {
  const std::vector<std::string> quick = {"limits.time_s=5", "start.distance_um=20",
                                          "success.depth_um=20"};
  std::vector<std::string> poor = quick;
  for (const char* each : {"sensor.noise_uN=4", "sensor.bias_uN=8", "sensor.bandwidth_Hz=50"})
    poor.push_back(each);
  double largest = 0, misread = 0;
  for (const bool errs : {false, true})
    for (int kind = 0; kind < Adversary::kKinds; ++kind)
      for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        const Closed c = run(load_scene("bench", errs ? poor : quick), kind, seed);
        EXPECT_LE(c.extremes.speed, 1 + 1e-12);
        EXPECT_LE(c.extremes.change, 1 + 1e-9);
        EXPECT_TRUE(c.extremes.always_finite && c.extremes.stops_are_whole);
        EXPECT_LE(c.force, errs ? 1 + c.misread : 1) << kind << " " << seed;
        largest = std::max(largest, c.force);
        misread = std::max(misread, c.misread);
      }
  EXPECT_GT(largest, 0.9);  // it was braked for
  EXPECT_GT(misread, 0.1);  // and a sensor did err by more than the margin
}

// Perfectly smooth surfaces snap together and pull the fibre in with more than any limit. That is
// no motion of the hand's; what the hand adds stays within the limit.
TEST(Supervisor, AddsNothingToTheForceOfASnap) {
  std::vector<std::string> smooth = kCorrected;
  for (const char* each :
       {"roughness_nm=2", "limits.time_s=3", "start.distance_um=5", "start.lateral_sd_um=1"})
    smooth.push_back(each);
  std::size_t snaps = 0;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    const Closed c = run(load_scene("demo", smooth), Adversary::constant, seed);
    snaps += c.snaps;
    EXPECT_LE(c.caused, 0.9 + 1e-4);
    EXPECT_LE(c.extremes.change, 1 + 1e-9);
  }
  EXPECT_GT(snaps, 0u);
}

// Velocity by a function of time.
class Scripted : public Controller {
 public:
  explicit Scripted(std::function<HandTwist(double)> at, double apart = 0)
      : at_(std::move(at)), apart_(apart) {}
  HandTwist command(const Observation& observation) noexcept override {
    return at_(observation.time);
  }
  double disagreement() const noexcept override { return apart_; }

 private:
  std::function<HandTwist(double)> at_;
  double apart_;
};

HandTwist along(double x, double y, double z) {
  HandTwist v = HandTwist::Zero();
  v.head<3>() << x, y, z;
  return v;
}

TEST(Supervisor, LeavesAloneWhatKeepsTheLimits) {
  const SupervisorLimits limits = demo_limits();
  const auto gentle = [&](double t) {
    return HandTwist(0.9 * limits.speed * (1 - std::exp(-t / 0.2)) * along(-0.8, 0.6, 0));
  };
  Supervisor supervisor(std::make_unique<Scripted>(gentle), limits);
  for (int n = 0; n < 3000; ++n) {
    const double t = n * limits.period;
    HandWrench wrench = HandWrench::Zero();
    wrench[1] = 0.5 * limits.force * std::sin(t);
    const HandTwist v = supervisor.command({wrench, 0, t});
    ASSERT_LE((v - gentle(t)).norm(), 1e-14 * limits.speed);
  }
  for (const std::size_t count : supervisor.supervision()->interventions) EXPECT_EQ(count, 0u);
}

TEST(Supervisor, StopsAsItMayAndEndsWhenWhatIsCommandedIsNotFinite) {
  SupervisorLimits limits = demo_limits();
  limits.acceleration = limits.speed / 0.1;
  Supervisor supervisor(std::make_unique<Scripted>(
                            [&](double t) { return along(t < 0.5 ? -limits.speed : NAN, 0, 0); }),
                        limits);
  double before = 0;
  for (int n = 0; n <= 600; ++n) {
    const double v = -supervisor.command({HandWrench::Zero(), 0, n * limits.period})[0];
    const double speed = std::min(limits.speed, (n + 1) * limits.acceleration * limits.period);
    if (n < 500) {
      EXPECT_CLOSE(v, speed, 1e-9);
    } else {
      EXPECT_LE(std::abs(before - v - limits.speed / 100), 1e-9 * limits.speed);
    }
    before = v;
    EXPECT_EQ(supervisor.supervision()->gave_up.has_value(), n >= 599) << n;
    if (n == 599) break;
  }
  EXPECT_EQ(supervisor.supervision()->gave_up, Intervention::not_finite);
  EXPECT_EQ(supervisor.command({HandWrench::Zero(), 0, 1}).norm(), 0);
}

// A wall that pushes back with the limits' stiffness: F = k (depth past it) along its normal.
struct Wall {
  double stiffness;
  Eigen::Vector3d at, normal;
  HandWrench push(const Eigen::Vector3d& where) const {
    HandWrench wrench = HandWrench::Zero();
    wrench.head<3>() = stiffness * std::max(0.0, normal.dot(at - where)) * normal;
    return wrench;
  }
};

TEST(Supervisor, GoesBackTheWayItCameAndGivesUpAfterItsTries) {
  SupervisorLimits limits = demo_limits();
  limits.tries = 3;
  const double corner = 1.5;  // [s], when it turns towards the wall
  Supervisor supervisor(
      std::make_unique<Scripted>([&](double t) {
        return HandTwist(0.8 * limits.speed * (t < corner ? along(-0.6, 0.8, 0) : along(-1, 0, 0)));
      }),
      limits);
  const double in_x = 0.8 * limits.speed * (corner * 0.6 + 0.4);
  const Wall wall{limits.stiffness, {-in_x, 0, 0}, {1, 0, 0}};
  Eigen::Vector3d where = Eigen::Vector3d::Zero();
  std::vector<Eigen::Vector3d> way;
  double largest = 0, furthest_off = 0, back = 0;
  bool first_retreat = false;
  Eigen::Vector3d turned = where;
  int n = 0;
  for (; n < 60000 && !supervisor.supervision()->gave_up; ++n) {
    const HandWrench wrench = wall.push(where);
    largest = std::max(largest, wrench.norm());
    const HandTwist v = supervisor.command({wrench, 0, n * limits.period});
    const auto retreats =
        supervisor.supervision()->interventions[static_cast<std::size_t>(Intervention::retreat)];
    if (retreats == 0) {
      way.push_back(where);
      turned = where;
    }
    // The first time back, until it moves sideways from where it ended up.
    if (retreats == 1 && v[0] > 0 && !first_retreat) {
      double off = INFINITY;
      for (const Eigen::Vector3d& point : way) off = std::min(off, (point - where).norm());
      furthest_off = std::max(furthest_off, off);
      back = std::max(back, where[0] - turned[0]);
    }
    first_retreat |= retreats == 1 && back > 0 && v[0] <= 0;
    where += limits.period * v.head<3>();
  }
  const Supervision& done = *supervisor.supervision();
  EXPECT_LE(largest, 0.9 * limits.force * (1 + 1e-9));
  ASSERT_TRUE(done.gave_up.has_value());
  EXPECT_EQ(*done.gave_up, Intervention::jam);
  EXPECT_EQ(done.interventions[static_cast<std::size_t>(Intervention::retreat)], 3u);
  EXPECT_EQ(done.interventions[static_cast<std::size_t>(Intervention::jam)], 4u);
  EXPECT_EQ(done.interventions[static_cast<std::size_t>(Intervention::force_stop)], 0u);
  EXPECT_LT(furthest_off, limits.retreat / 16);
  EXPECT_GT(back, 0.6 * limits.retreat);
  EXPECT_LT(back, 1.1 * limits.retreat);
}

TEST(Supervisor, MovesTowardsWhereItWasPushedAndThenGetsPast) {
  const SupervisorLimits limits = demo_limits();
  Supervisor supervisor(
      std::make_unique<Scripted>([&](double) { return along(-limits.speed, 0, 0); }), limits);
  // A slope that only ends an offset and a half further in z than it is met.
  const Eigen::Vector3d normal = Eigen::Vector3d(0.5, 0, std::sqrt(0.75));
  const Wall wall{limits.stiffness, {-2 * limits.offset, 0, 0}, normal};
  Eigen::Vector3d where = Eigen::Vector3d::Zero();
  int n = 0;
  for (; n < 20000 && where[0] > -8 * limits.offset; ++n) {
    const bool past = where[2] > 1.5 * limits.offset;
    const HandWrench wrench = past ? HandWrench(HandWrench::Zero()) : wall.push(where);
    where += limits.period * supervisor.command({wrench, 0, n * limits.period}).head<3>();
  }
  EXPECT_LT(n, 20000);
  EXPECT_CLOSE(where[2], 2 * limits.offset, 0.02);
  EXPECT_LE(std::abs(where[1]), 1e-6 * limits.offset);
  EXPECT_EQ(
      supervisor.supervision()->interventions[static_cast<std::size_t>(Intervention::retreat)], 2u);
}

TEST(Supervisor, DisagreementSlowsThenRetreatsThenGivesUp) {
  SupervisorLimits limits = demo_limits();
  limits.tries = 2;
  Supervisor supervisor(
      std::make_unique<Scripted>([&](double) { return along(-limits.speed, 0, 0); },
                                 4 * limits.disagreement),
      limits);
  int n = 0;
  double fastest = 0;
  for (; n < 30000 && !supervisor.supervision()->gave_up; ++n) {
    const double v = -supervisor.command({HandWrench::Zero(), 0, n * limits.period})[0];
    if (n < 490) fastest = std::max(fastest, v);
  }
  EXPECT_CLOSE(fastest, limits.speed / 4, 1e-12);
  EXPECT_EQ(supervisor.supervision()->gave_up, Intervention::disagreement);
  EXPECT_EQ(
      supervisor.supervision()->interventions[static_cast<std::size_t>(Intervention::retreat)], 2u);
}

TEST(Supervisor, MakesConstantVelocityInsertMoreOften) {
  const Scene scene = load_scene("demo");
  const Scaling scaling = scene_scaling(scene);
  const MakeController naive =
      controller_maker(ConstantVelocity(scaling.motion * scene.limits.speed));
  const auto alone = summarise(run_campaign(scene, scaling, naive, 11, 24, 0, {}));
  const auto kept = summarise(run_campaign(
      scene, scaling, supervised(naive, supervisor_limits(scene, scaling)), 11, 24, 0, {}));
  EXPECT_LT(alone.successes, 18u);
  EXPECT_GE(kept.successes, 21u);
  EXPECT_FALSE(alone.interventions.has_value());
  ASSERT_TRUE(kept.interventions.has_value());
  EXPECT_GE(kept.interventions->kinds[static_cast<std::size_t>(Intervention::retreat)].trials,
            kept.successes - alone.successes);
  EXPECT_LE(kept.peak_force.p95, 0.9 * scene.limits.force * (1 + 1e-3));
}

TEST(Supervisor, SummaryCountsByKindAndTrial) {
  std::vector<TrialResult> results(4);
  for (TrialResult& r : results) r.supervision.emplace();
  (*results[0].supervision)[Intervention::jam] = 3;
  (*results[2].supervision)[Intervention::jam] = 1;
  (*results[2].supervision)[Intervention::retreat] = 2;
  results[2].supervision->gave_up = Intervention::jam;
  const InterventionSummary s = *summarise(results).interventions;
  EXPECT_EQ(s.trials, 2u);
  EXPECT_EQ(s.kinds[static_cast<std::size_t>(Intervention::jam)].count, 4u);
  EXPECT_EQ(s.kinds[static_cast<std::size_t>(Intervention::jam)].trials, 2u);
  EXPECT_EQ(s.kinds[static_cast<std::size_t>(Intervention::retreat)].count, 2u);
  EXPECT_EQ(s.gave_up[static_cast<std::size_t>(Intervention::jam)], 1u);
}

TEST(Supervisor, ARecordingOfOneThatGivesUpSaysWhyAndPlaysAgain) {
  const testing::TemporaryFolder folder;
  const Scene scene = testing::paper({"start.distance_um=20"});
  const auto broken = [](double t) { return along(t < 0.3 ? -1e-3 : NAN, 0, 0); };
  const auto make = [&] {
    return Supervisor(std::make_unique<Scripted>(broken),
                      supervisor_limits(scene, scene_scaling(scene)));
  };
  Supervisor in_trial = make(), recorded = make();
  const TrialResult result = run_trial(scene, scene_scaling(scene), in_trial, 1, 1);
  EXPECT_EQ(result.outcome, Outcome::gave_up);
  EXPECT_EQ(result.supervision->gave_up, Intervention::not_finite);
  const Episode episode = read_episode(testing::record(scene, folder.path(), 1, &recorded));
  EXPECT_EQ(episode.info.outcome, Outcome::gave_up);
  EXPECT_EQ(episode.info.why, "not_finite");
  EXPECT_FALSE(verify(episode).has_value());
  EXPECT_CLOSE(episode.rows(episode.rows.rows() - 1, kTime.begin), result.summary.time, 1e-12);
}

}  // namespace
}  // namespace ferrule
