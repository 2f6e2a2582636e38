#include "haptic/trainee.hpp"

#include <complex>

#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

const TraineeTask kTask = {HandPose::Zero(), 0.02, 2e-3, 0, 1e-3};

std::function<double()> chance(std::uint64_t trial) {
  return
      [random = RandomStream(1, trial, Draw::operator_hand)]() mutable { return random.uniform(); };
}

// Poses of a trainee that feels `force(t)`.
template <class Force>
std::vector<HandPose> run(TraineeTraits traits, Force force, std::uint64_t trial = 0) {
  Trainee trainee(traits, kTask, chance(trial));
  std::vector<HandPose> poses;
  for (int n = 0; n < 100000; ++n) {
    const HandSample sample = trainee.read(n * 1e-3);
    if (sample.finished) break;
    poses.push_back(sample.pose);
    HandWrench w = HandWrench::Zero();
    w.head<3>() = force(n * 1e-3);
    trainee.render(w);
  }
  return poses;
}

TraineeTraits steady(double skill) {
  TraineeTraits traits = trainee_traits(skill);
  traits.tremor = traits.hesitation_rate = 0;
  return traits;
}

TEST(Trainee, InFreeAirMakesAMinimumJerkMotion) {
  const auto poses = run(steady(1), [](double) { return Eigen::Vector3d::Zero(); });
  const double duration = 1.875 * kTask.distance / kTask.speed;
  EXPECT_CLOSE(poses.back()[0], -kTask.distance, 1e-9);
  for (const double p : {0.25, 0.5, 0.8}) {
    const double s = p * p * p * (10 - 15 * p + 6 * p * p);
    const auto n = static_cast<std::size_t>((0.3 + p * duration) * 1e3);
    EXPECT_CLOSE(poses[n][0], -kTask.distance * s, 2e-3);
  }
  for (const auto& pose : poses) EXPECT_EQ(pose[1], 0);
}

TEST(Trainee, AnswersForceAfterItsDelay) {
  for (const double skill : {0.0, 0.5, 1.0}) {
    const TraineeTraits traits = steady(skill);
    const auto poses =
        run(traits, [](double t) { return Eigen::Vector3d(0, t >= 1.0 ? 1.0 : 0.0, 0); });
    std::size_t first = 0;
    while (poses[first][1] == 0) ++first;
    // In samples of a millisecond.
    EXPECT_LE(std::abs(static_cast<double>(first) - 1e3 * (1.0 + traits.delay)), 2.1);
    EXPECT_CLOSE(poses[first + 1000][1] - poses[first][1], traits.yield * 1.0, 1e-6);
  }
  EXPECT_CLOSE(trainee_traits(0).delay, 0.25, 1e-12);
  EXPECT_CLOSE(trainee_traits(1).delay, 0.15, 1e-12);
}

// Velocity sideways and rates of tilt of one who has felt `wrench` for long, `part` of the way in.
HandTwist answer(const TraineeTraits& traits, const TraineeTask& task, const HandWrench& wrench,
                 double part) {
  Trainee trainee(traits, task, chance(0));
  HandPose pose = task.start;
  pose[0] -= part * task.distance;
  HandTwist last;
  for (int n = 0; n < 1000; ++n) last = trainee.answer(1 + 1e-3 * n, pose, wrench);
  return last;
}

TEST(Trainee, YieldsByPlaceForceAndPhase) {
  TraineeTraits traits = steady(0.5);
  TraineeTask task = kTask;
  task.entrance = 0.4 * task.distance;
  HandWrench wrench;
  const double f = traits.slowing_force;
  wrench << 0, 0.6 * f, 0.8 * f, 0.3, -0.2;
  const HandTwist constant = answer(traits, task, wrench, 0.5);
  const auto times = [&](const TraineeTraits& other, double part) {
    const HandTwist v = answer(other, task, wrench, part);
    EXPECT_CLOSE(v[1] / constant[1], v[2] / constant[2], 1e-9);
    return v[2] / constant[2];
  };
  traits.bore_yield = 3;
  EXPECT_CLOSE(times(traits, 0.39), 1, 1e-9);
  EXPECT_CLOSE(times(traits, 0.41), 3, 1e-9);
  traits = steady(0.5);
  traits.force_yield = 5;  // half of the way to it at F_s
  EXPECT_CLOSE(times(traits, 0.5), 3, 1e-9);
  wrench.head<3>() *= 1e4;
  EXPECT_CLOSE(times(traits, 0.5), 1e4 * 5, 1e-6);
  wrench.head<3>() /= 1e4;
  traits = steady(0.5);
  traits.late_yield = 2;  // half of the way is made at half the phase
  EXPECT_CLOSE(times(traits, 0.5), 1.5, 1e-3);
}

TEST(Trainee, TiltsUnderMomentsAfterItsDelay) {
  TraineeTraits traits = steady(1);
  HandWrench wrench;
  wrench << 0, 0.5, 0, 0.3, -0.2;
  EXPECT_EQ(answer(traits, kTask, wrench, 0.1).tail<2>().norm(), 0);
  traits.tilt_yield = 2e-3;
  EXPECT_EQ(answer(traits, kTask, wrench, 0.1).tail<2>(), 2e-3 * wrench.tail<2>());
}

TEST(Trainee, SlowsDownUnderForce) {
  const TraineeTraits traits = steady(0.8);
  const double f = traits.slowing_force;
  const auto free = run(traits, [](double) { return Eigen::Vector3d::Zero(); });
  const auto loaded =
      run(traits, [f](double t) { return Eigen::Vector3d(t > 0.05 ? f : 0.0, 0, 0); });
  EXPECT_CLOSE(static_cast<double>(loaded.size()) - 800,
               2 * (static_cast<double>(free.size()) - 800), 0.02);
}

TEST(Trainee, TremblesBetweenEightAndTwelveHertz) {
  TraineeTraits traits = trainee_traits(0.5);
  traits.hesitation_rate = 0;
  const auto poses = run(traits, [](double) { return Eigen::Vector3d::Zero(); });
  const std::size_t n = 8000;
  double inside = 0, outside = 0;
  for (int k = 1; k < 400; ++k) {  // 0.125 Hz apart
    std::complex<double> sum = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double window = std::pow(std::sin(std::acos(-1) * i / n), 2);
      sum += window * (poses[i + 400][2]) *
             std::polar(1.0, -2 * std::acos(-1) * k * static_cast<double>(i) / n);
    }
    const double hz = k * 1e3 / n;
    (hz > 7.5 && hz < 12.5 ? inside : outside) += hz > 2 ? std::norm(sum) : 0;
  }
  EXPECT_GT(inside, 100 * outside);
}

// Seen, the axis is reached before the entrance, along the path of least jerk; then it keeps it.
TEST(Trainee, SteersOntoTheAimThatItSees) {
  TraineeTask task = kTask;
  task.aim = {0.008, {1e-3, -2e-3}};
  Trainee trainee(steady(1), task, [] { return 0.5; });
  double fastest = 0;
  Eigen::Vector2d before = Eigen::Vector2d::Zero();
  for (int n = 0; n < 30000; ++n) {
    const HandSample sample = trainee.read(1e-3 * n);
    trainee.render(HandWrench::Zero());
    const double s = -sample.pose[0] / task.aim->within;
    const double m = s < 1 ? s * s * s * (10 - 15 * s + 6 * s * s) : 1;
    EXPECT_LT((sample.pose.segment<2>(1) - m * task.aim->lateral).norm(), 2e-6) << s;
    fastest = std::max(fastest, (sample.pose.segment<2>(1) - before).norm() / 1e-3);
    before = sample.pose.segment<2>(1);
    if (sample.finished) break;
  }
  EXPECT_LT((before - task.aim->lateral).norm(), 1e-8);
  EXPECT_LT(fastest, task.speed);
}

TEST(Trainee, SkillMovesEveryTrait) {
  const TraineeTraits a = trainee_traits(0.2), b = trainee_traits(0.9);
  EXPECT_GT(a.delay, b.delay);
  EXPECT_LT(a.peak_speed, b.peak_speed);
  EXPECT_LT(a.yield, b.yield);
  EXPECT_LT(a.slowing_force, b.slowing_force);
  EXPECT_GT(a.tremor, b.tremor);
  EXPECT_GT(a.hesitation_rate, b.hesitation_rate);
}

// Fig. 10 of the paper: the speed rises to about 8 um/s and falls back to 0, sideways velocities
// stay within about 2 um/s, and near the end the contact force is -5 to -10 uN.
TEST(Trainee, InsertsAsInFig10OfThePaper) {
  const Scene scene = testing::paper();
  for (const std::uint64_t trial : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u, 9u, 10u, 11u, 12u}) {
    const State start = draw_start(scene, 1, trial);
    const auto device = simulated_operator(testing::setup(scene, trial), 0.8);
    const auto [end, rows] = testing::record_rows(scene, start, *device);
    EXPECT_EQ(end.outcome, Outcome::inserted);
    const double to_um = 1e6 / scene_scaling(scene).motion;
    double fastest = 0, sideways = 0;
    for (const RowVector& row : rows) {
      const auto v = row.segment<3>(kCommand.begin) * to_um;
      fastest = std::max(fastest, -v[0]);
      sideways = std::max({sideways, std::abs(v[1]), std::abs(v[2])});
    }
    EXPECT_GT(fastest, 6.5);
    EXPECT_LT(fastest, 9.5);
    EXPECT_LT(sideways, 2.5);
    EXPECT_LT(std::abs(rows.back()[kCommand.begin] * to_um), 1.5);
    for (std::size_t n = rows.size() - 1000; n < rows.size(); ++n) {
      const double adhesion_y = 1e6 * rows[n][force_column(Term::adhesion) + 1];
      const double friction_y = 1e6 * rows[n][force_column(Term::friction) + 1];
      EXPECT_GT(adhesion_y + friction_y, -10) << trial;
      ASSERT_LT(adhesion_y + friction_y, -5) << trial;
    }
  }
}

}  // namespace
}  // namespace ferrule
