// What a supervisor does in trouble: it leaves alone, stops, goes back, tries again, gives up.
#include "controller/supervisor.hpp"

#include "capture/replay.hpp"
#include "controller/campaign.hpp"
#include "insertion/scene_scaling.hpp"
#include "tests/compare.hpp"
#include "tests/demo_limits.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

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
  const SupervisorLimits limits = testing::demo_limits();
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

// The scene's speed limit is none of tilts: they are slowed by what they may strain.
TEST(Supervisor, LetsATiltGoFasterThanTheSpeedAtTheLever) {
  SupervisorLimits limits = testing::demo_limits();
  limits.acceleration = limits.speed / limits.period;
  limits.stiffness = 0.1 * limits.force / (limits.speed * limits.period);
  HandTwist tilt = HandTwist::Zero();
  tilt[3] = 3 * limits.speed / limits.lever;
  Supervisor supervisor(std::make_unique<Scripted>([&](double) { return tilt; }), limits);
  for (int n = 0; n < 10; ++n) {
    const HandTwist v = supervisor.command({HandWrench::Zero(), 0, n * limits.period});
    EXPECT_CLOSE(v[3], std::min(n + 1, 3) * limits.speed / limits.lever, 1e-12) << n;
  }
}

// A motion that is mostly across what is felt is slowed, and goes where it was sent.
TEST(Supervisor, DoesNotTurnWhatItSlows) {
  const SupervisorLimits limits = testing::demo_limits();
  Supervisor supervisor(
      std::make_unique<Scripted>([&](double) { return along(0, -limits.speed, 0); }), limits);
  HandWrench wrench = HandWrench::Zero();
  wrench.head<3>() = 0.899 * limits.force * Eigen::Vector3d(0.8, -0.6, 0);
  for (int n = 0; n < 200; ++n) {
    const HandTwist v = supervisor.command({wrench, 0, n * limits.period});
    EXPECT_LT(v[1], 0);
    EXPECT_GT(v[1], -0.9 * limits.speed);
    EXPECT_EQ(v[0], 0) << n;
  }
}

// Again and again it presses for 0.3 s and goes back by itself.
TEST(Supervisor, LeavesWhoTouchesAlone) {
  const SupervisorLimits limits = testing::demo_limits();
  const auto touches = [&](double t) {
    return along((std::fmod(t, 1.0) < 0.6 ? -0.1 : 0.15) * limits.speed, 0, 0);
  };
  Supervisor supervisor(std::make_unique<Scripted>(touches), limits);
  double x = 0;
  const double wall = -0.03 * limits.speed;
  for (int n = 0; n < 10000; ++n) {
    HandWrench wrench = HandWrench::Zero();
    wrench[0] = std::max(0.0, wall - x) / (0.03 * limits.speed) * 0.7 * limits.force;
    x += limits.period * supervisor.command({wrench, 0, n * limits.period})[0];
  }
  EXPECT_EQ((*supervisor.supervision())[Intervention::retreat], 0u);
}

TEST(Supervisor, StopsAsItMayAndEndsWhenWhatIsCommandedIsNotFinite) {
  SupervisorLimits limits = testing::demo_limits();
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
  SupervisorLimits limits = testing::demo_limits();
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
    const auto retreats = (*supervisor.supervision())[Intervention::retreat];
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
  EXPECT_EQ(done[Intervention::retreat], 3u);
  EXPECT_EQ(done[Intervention::jam], 4u);
  EXPECT_EQ(done[Intervention::force_stop], 0u);
  EXPECT_LT(furthest_off, limits.retreat / 16);
  EXPECT_GT(back, 0.6 * limits.retreat);
  EXPECT_LT(back, 1.1 * limits.retreat);
}

TEST(Supervisor, MovesTowardsWhereItWasPushedAndThenGetsPast) {
  const SupervisorLimits limits = testing::demo_limits();
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
  EXPECT_EQ((*supervisor.supervision())[Intervention::retreat], 2u);
}

TEST(Supervisor, DisagreementSlowsThenRetreatsThenGivesUp) {
  SupervisorLimits limits = testing::demo_limits();
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
  EXPECT_EQ((*supervisor.supervision())[Intervention::retreat], 2u);
}

TEST(SupervisorAtLength, MakesConstantVelocityInsertMoreOften) {
  const Scene scene = load_scene("demo");
  const Scaling scaling = scene_scaling(scene);
  const MakeController naive =
      controller_maker(ConstantVelocity(scaling.motion * scene.limits.speed));
  const auto alone = summarise(run_campaign(scene, naive, 11, 24, 0, {}));
  const auto kept =
      summarise(run_campaign(scene, supervised(naive, supervisor_limits(scene)), 11, 24, 0, {}));
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
    return Supervisor(std::make_unique<Scripted>(broken), supervisor_limits(scene));
  };
  Supervisor in_trial = make(), recorded = make();
  const TrialResult result = run_trial(scene, in_trial, 1, 1);
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
