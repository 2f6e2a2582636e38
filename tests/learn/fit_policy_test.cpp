#include "learn/fit_policy.hpp"

#include <nlohmann/json.hpp>
#include <set>

#include "controller/campaign.hpp"
#include "controller/searching_operator.hpp"
#include "learn/record_again.hpp"
#include "learn/relabel.hpp"
#include "tests/compare.hpp"
#include "tests/demonstrations.hpp"
#include "tests/episodes.hpp"
#include "tests/policies.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

bool without_libtorch() {
  try {
    torchscript_bytes(testing::random_policy(1, {2}, 1, 1));
    return false;
  } catch (const BadInput& error) {
    EXPECT_NE(std::string(error.what()).find("libtorch-dev"), std::string::npos);
    return true;
  }
}
#define NEEDS_LIBTORCH \
  if (without_libtorch()) GTEST_SKIP() << "built without libtorch"

// A linear law: v = A f + c d + v_0, and what it says of one state.
const Eigen::Matrix3d kYield = Eigen::Vector3d(2e-4, 1e-3, 0.7e-3).asDiagonal();
const Eigen::Vector3d kLean(0.02, -0.03, 0.01), kOwn(-3e-3, 1e-4, -2e-4);
Eigen::Vector3d law(const Eigen::Vector3d& force, double depth) {
  return kYield * force + kLean * depth + kOwn;
}

// Demonstrations of it that answer `delay` ms late.
DemonstrationSet demonstrations(int episodes, int delay, std::uint64_t seed = 1) {
  return testing::demonstrations(
      [](const Eigen::Vector3d& force, double depth, double) { return law(force, depth); }, 0.01,
      episodes, delay, 0, seed);
}

PolicySettings quick() {
  PolicySettings s;
  s.training.epochs = 15;
  s.training.hidden = {32, 32};
  return s;
}

// Root mean square of the error against the law on episodes that were not trained on, per channel,
// of the velocities' standard deviation.
double error_against_law(const Policy& policy) {
  const DemonstrationSet others = demonstrations(4, 0, 99);
  double sum = 0, n = 0;
  for (const Demonstration& d : others.demonstrations) {
    PolicyController controller(policy);
    for (Eigen::Index i = 0; i < d.rows(); ++i) {
      const Observation& o = d.observed(i);
      const Eigen::Vector3d v = controller.command(o).head<3>();
      if (i < 100) continue;  // until it has a past
      sum +=
          (v - law(o.wrench.head<3>(), o.depth)).cwiseQuotient(policy.velocity_scale).squaredNorm();
      n += 3;
    }
  }
  return std::sqrt(sum / n);
}

TEST(FitPolicyInSeconds, ReproducesALinearLawOnStatesItHasNotSeenWithin3Percent) {
  NEEDS_LIBTORCH;
  PolicySettings settings;
  settings.training.epochs = 40;
  settings.samples = 1;
  EXPECT_LT(error_against_law(fit_policy(demonstrations(8, 0), settings, {}).file.policy), 0.03);
}

// Demonstrated 180 ms late, answered at once. Answered as late it would be off by half and more.
TEST(FitPolicy, UndoesTheReactionTime) {
  NEEDS_LIBTORCH;
  const PolicyFit fit = fit_policy(demonstrations(8, 180), quick(), {});
  EXPECT_CLOSE(fit.file.reaction_time, 0.18, 1e-9);
  EXPECT_LT(error_against_law(fit.file.policy), 0.1);
}

TEST(FitPolicy, TheSameSeedGivesTheSameBytes) {
  NEEDS_LIBTORCH;
  const testing::TemporaryFolder folder;
  PolicySettings settings = quick();
  settings.training.epochs = 2;
  settings.members = 2;
  const DemonstrationSet set = demonstrations(4, 0);
  const auto write = [&](const char* name) {
    write_controller(folder / (std::string(name) + ".json"), fit_policy(set, settings, {}).file);
    const auto file = nlohmann::json::parse(read_text(folder / (std::string(name) + ".json")));
    return read_text(folder / file.at("weights").get<std::string>());
  };
  const std::string first = write("a"), again = write("b");
  EXPECT_EQ(first, again);
  settings.seed = 2;
  EXPECT_NE(write("c"), first);
  const Policy p = read_policy(folder / "a.json").policy;
  EXPECT_NE(p.members[0][0].weight, p.members[1][0].weight) << "members start differently";
}

// Scaled rows of noise, on which one epoch is as good as another.
std::vector<TrainingRows> noise(int demonstrations, int rows, std::uint64_t seed) {
  constexpr int kInputs = 13;
  RandomStream random(seed, 0, Draw::plan);
  std::vector<TrainingRows> all;
  for (int d = 0; d < demonstrations; ++d) {
    const auto normal = [&] { return static_cast<float>(random.normal()); };
    all.push_back({Eigen::MatrixXf::NullaryExpr(kInputs, rows, normal),
                   Eigen::MatrixXf::NullaryExpr(3, rows, normal), Eigen::RowVectorXf::Ones(rows)});
  }
  return all;
}

// What grades a held-out demonstration is what the others alone would have kept.
TEST(TrainNetworkInSeconds, ADemonstrationDoesNotChooseTheWeightsThatItGrades) {
  NEEDS_LIBTORCH;
  for (const int memory : {0, 8}) {
    TrainingSettings settings;
    settings.epochs = settings.patience = 12;
    settings.learning_rate = 1e-2;
    settings.hidden = {8};
    settings.memory = memory;
    settings.window = 50;
    const std::vector<TrainingRows> training = noise(4, 200, 1), held_out = noise(4, 30, 2);
    const TrainedNetwork all = train_network(training, held_out, settings, 1, {});
    ASSERT_EQ(all.chosen_without.size(), held_out.size());
    std::set<std::size_t> epochs;
    for (std::size_t e = 0; e < held_out.size(); ++e) {
      std::vector<TrainingRows> others = held_out;
      others.erase(others.begin() + static_cast<std::ptrdiff_t>(e));
      const TrainedNetwork by_others = train_network(training, others, settings, 1, {});
      epochs.insert(by_others.best);
      for (std::size_t i = 0; i < by_others.weights.network.size(); ++i)
        EXPECT_EQ(all.chosen_without[e].network[i].weight, by_others.weights.network[i].weight);
      EXPECT_EQ(all.chosen_without[e].memory.memory_weight, by_others.weights.memory.memory_weight);
    }
    EXPECT_GT(epochs.size(), 1u) << "all choose alike: this shows nothing";
    EXPECT_TRUE(train_network(training, noise(1, 30, 2), settings, 1, {}).chosen_without.empty());
  }
}

// An epoch may take long: it is stopped after any step, and counts as far as it went.
TEST(TrainNetwork, IsStoppedWithinAnEpoch) {
  NEEDS_LIBTORCH;
  for (const int memory : {0, 8}) {
    TrainingSettings settings;
    settings.epochs = 3;
    settings.hidden = {8};
    settings.memory = memory;
    settings.window = 50;
    settings.batch = 20;
    settings.together = 1;
    for (const std::size_t last : {2u, 5u, 20u}) {  // an epoch has 16 steps, or 40
      std::size_t asked = 0;
      const TrainedNetwork part = train_network(
          noise(4, 200, 1), noise(2, 30, 2), settings, 1, [&](std::size_t epochs, const Epoch& e) {
            EXPECT_EQ(std::isnan(e.training_loss), epochs == 0);
            return ++asked < last;
          });
      EXPECT_LE(asked, last + 1) << "after a step, and where the epoch ends";
      ASSERT_FALSE(part.weights.network.empty());
      EXPECT_EQ(part.curve.size(), memory > 0 && last == 20 ? 2U : 1U);
      EXPECT_TRUE(std::isfinite(part.curve.back().training_loss));
      EXPECT_TRUE(part.weights.network.front().weight.allFinite());
    }
  }
}

// What is whole is kept: members of an ensemble, rounds of DAgger.
TEST(FitPolicy, KeepsWhatIsWholeWhereItIsStopped) {
  NEEDS_LIBTORCH;
  PolicySettings settings = quick();
  settings.training.epochs = 2;
  settings.members = 3;
  const DemonstrationSet set = demonstrations(10, 0);
  const auto until = [](std::size_t epochs) {
    return [epochs, asked = 0](std::size_t done, const Epoch&) mutable {
      return done < epochs || ++asked < 3;  // some steps later
    };
  };
  PolicyFile part = fit_policy(set, settings, until(2)).file;
  EXPECT_TRUE(part.trained_on.partial);
  EXPECT_EQ(part.policy.members.size(), 1U);
  EXPECT_EQ(part.members.size(), 1U);
  EXPECT_GT(part.held_out_residual, 0);

  settings.members = 1;
  settings.dagger_rounds = 2;
  const DemonstrationSet by_operator = simulated_demonstrations(testing::quick(), 0.8, 1, 4);
  part = fit_policy(by_operator, settings, until(4)).file;
  EXPECT_TRUE(part.trained_on.partial);
  EXPECT_EQ(part.dagger.size(), 1U);
  EXPECT_EQ(part.trained_on.rollouts, 10U);
  settings.dagger_rounds = 1;
  const PolicyFile whole = fit_policy(by_operator, settings, {}).file;
  EXPECT_FALSE(whole.trained_on.partial);
  EXPECT_EQ(part.policy.members[0][0].weight, whole.policy.members[0][0].weight);
  EXPECT_EQ(part.residual, whole.residual);
}

TEST(FitPolicy, OneDemonstrationThatChoseTheEpochDoesNotGradeIt) {
  NEEDS_LIBTORCH;
  const testing::TemporaryFolder folder;
  PolicySettings settings = quick();
  settings.training.epochs = 2;
  EXPECT_GT(fit_policy(demonstrations(10, 0), settings, {}).file.held_out_residual, 0);
  const PolicyFile few = fit_policy(demonstrations(9, 0), settings, {}).file;
  EXPECT_TRUE(std::isnan(few.held_out_residual));
  write_controller(folder / "few.json", few);
  EXPECT_TRUE(std::isnan(read_policy(folder / "few.json").held_out_residual));
}

// Demonstrations of who goes the faster the harder the touch was that came in the first half second.
DemonstrationSet demonstrations_by_memory(int episodes, std::uint64_t seed) {
  DemonstrationSet set = testing::demonstrations(
      [](const Eigen::Vector3d&, double, double) { return Eigen::Vector3d(-3e-3, 0, 0); }, 0.01,
      episodes, 0, 0, seed);
  RandomStream random(seed, 1, Draw::plan);
  for (Demonstration& d : set.demonstrations) {
    const double touch = random.uniform();
    d.velocity.conservativeResize(2500, Eigen::NoChange);
    d.tilt_rates.conservativeResize(2500, Eigen::NoChange);
    for (Eigen::Index n = 0; n < d.rows(); ++n) {
      Observation& o = d.observations[static_cast<std::size_t>(n)];
      o.wrench.setZero();
      if (o.time < 0.5) o.wrench[0] = touch;
      d.velocity.row(n) << -2e-3 - (o.time < 0.5 ? 0 : 4e-3 * touch), 0, 0;
      d.tilt_rates.row(n) << 0.1 * touch, 0;
    }
  }
  return set;
}

TEST(FitPolicyInSeconds, WithAMemoryAnswersWhatWasFeltLongAgo) {
  NEEDS_LIBTORCH;
  PolicySettings settings = memory_settings();
  settings.training.memory = 16;
  settings.training.hidden = {16};
  settings.training.epochs = 100;
  settings.rollouts = 0;  // there is no scene to insert in
  const PolicyFile fitted = fit_policy(demonstrations_by_memory(40, 1), settings, {}).file;
  const PolicyFile forgets = fit_policy(demonstrations_by_memory(10, 1), quick(), {}).file;
  ASSERT_EQ(fitted.policy.answers(), kTwist);
  double error = 0, without = 0;
  const DemonstrationSet others = demonstrations_by_memory(8, 99);
  for (const Demonstration& d : others.demonstrations) {
    PolicyController remembers(fitted.policy), does_not(forgets.policy);
    for (Eigen::Index n = 0; n < d.rows(); ++n) {
      const HandTwist v = remembers.command(d.observed(n)), w = does_not.command(d.observed(n));
      error += std::abs(v[0] - d.velocity(n, 0)) / 4e-3 + std::abs(v[3] - d.tilt_rates(n, 0)) / 0.1;
      without +=
          std::abs(w[0] - d.velocity(n, 0)) / 4e-3 + std::abs(w[3] - d.tilt_rates(n, 0)) / 0.1;
    }
  }
  EXPECT_LT(error, 0.25 * without);
}

TEST(FitPolicy, AVelocityThatDoesNotVaryIsAnsweredExactly) {
  NEEDS_LIBTORCH;
  DemonstrationSet set = demonstrations(4, 0);
  for (auto& d : set.demonstrations) d.velocity.col(2).setConstant(1.5e-3);
  PolicyController controller(fit_policy(set, quick(), {}).file.policy);
  EXPECT_CLOSE(controller.command({HandWrench::Ones(), 0.01, 0})[2], 1.5e-3, 1e-12);
}

TEST(FitPolicy, RefusesTooLittle) {
  for (const int episodes : {0, 2}) try {
      fit_policy(demonstrations(episodes, 0), quick(), {});
      FAIL();
    } catch (const BadInput& error) {
      EXPECT_NE(std::string(error.what()).find("too few demonstrations"), std::string::npos);
    }
}

// What libtorch answers from the TorchScript is what the controller answers.
TEST(TorchScript, IsThePolicyTo1e6) {
  NEEDS_LIBTORCH;
  for (const std::size_t members : {1u, 4u}) {
    Policy p = testing::random_policy(members, {64, 64}, 2, 1, members);
    p.speed_limit = p.velocity_mean.norm();  // cuts some of them
    Eigen::MatrixXd inputs(p.inputs(), 200);
    std::vector<HandTwist> ours;
    std::vector<PolicyAnswer> answers;
    RandomStream random(2, members, Draw::plan);
    PolicyController controller(p);
    std::vector<Observation> seen;
    std::size_t cut = 0;
    for (int n = 0; n < 200; ++n) {
      seen.push_back(testing::random_observation(random));
      inputs.col(n) = testing::policy_inputs(p, seen);
      ours.push_back(controller.command(seen.back()));
      answers.push_back(controller.answer());
      cut += answers.back().velocity.norm() > p.speed_limit;
    }
    EXPECT_GT(cut, 10u);
    EXPECT_LT(cut, 190u);
    const Eigen::MatrixXd theirs = run_torchscript(torchscript_bytes(p), inputs);
    for (int n = 0; n < 200; ++n)
      for (int i = 0; i < kVelocity; ++i) {
        const auto at = static_cast<std::size_t>(n);
        const double scale = p.velocity_scale[i];
        EXPECT_NEAR(theirs(i, n), ours[at][i], 1e-6 * scale);
        EXPECT_NEAR(theirs(3 + i, n), answers[at].deviation[i], 2e-6 * answers[at].deviation[i]);
        EXPECT_NEAR(theirs(6 + i, n), answers[at].disagreement[i], 1e-6 * scale);
      }
  }
}

TEST(TorchScript, OfOneThatRemembersIsThePolicyTo1e5) {
  NEEDS_LIBTORCH;
  Policy p = testing::random_policy(2, {32}, 1, 1, 5, 24, true);
  p.speed_limit = p.velocity_mean.head<3>().norm();
  Eigen::MatrixXd inputs(p.inputs(), 100);
  std::vector<HandTwist> ours;
  std::vector<PolicyAnswer> answers;
  RandomStream random(2, 0, Draw::plan);
  PolicyController controller(p);
  for (int n = 0; n < 100; ++n) {
    const Observation o = testing::random_observation(random);
    inputs.col(n) = testing::policy_inputs(p, {o});
    ours.push_back(controller.command(o));
    answers.push_back(controller.answer());
  }
  const Eigen::MatrixXd theirs = run_torchscript(torchscript_bytes(p), inputs, {2, 24});
  for (int n = 0; n < 100; ++n)
    for (int i = 0; i < kTwist; ++i) {
      const auto at = static_cast<std::size_t>(n);
      EXPECT_NEAR(theirs(i, n), ours[at][i], 1e-5 * p.velocity_scale[i]);
      EXPECT_NEAR(theirs(5 + i, n), answers[at].deviation[i], 1e-5 * answers[at].deviation[i]);
      EXPECT_NEAR(theirs(10 + i, n), answers[at].disagreement[i], 1e-5 * p.velocity_scale[i]);
    }
}

// Whatever it feels.
Policy straight_in(double period) {
  Policy p = testing::random_policy(1, {4}, 1, 1);
  p.velocity_scale.setZero();
  p.velocity_mean = Eigen::Vector3d(-4e-3, 0, 0);
  p.period = period;
  return p;
}

// The operator who is asked answers what was felt one reaction time before, and slows down towards
// the end of the way, wherever the policy has led the hand.
TEST(Relabel, IsWhatTheOperatorWouldDo) {
  const Scene scene = load_scene("demo");
  const Policy p = straight_in(kStep);
  const double reaction = 0.15;
  const Demonstration d = relabelled_trial(scene, p, {0.8}, reaction, 1, 3);
  const double yield = trainee_traits(0.8).yield;
  const auto delay = static_cast<Eigen::Index>(std::lround(reaction / kStep));
  Eigen::Index compared = 0;
  for (Eigen::Index n = 100; n < d.rows(); ++n) {
    // To one tick of the ring that delays it.
    const double late = yield * d.observed(n - delay).wrench[2],
                 later = yield * d.observed(n - delay - 1).wrench[2];
    EXPECT_LE(std::min(std::abs(d.velocity(n, 2) - late), std::abs(d.velocity(n, 2) - later)),
              1e-9 * yield);
    EXPECT_LE(d.velocity(n, 0), 0);
    compared += std::abs(late) > 1e-5;
  }
  EXPECT_GT(compared, 100);
}

// One who searches is asked as well: led against the face, he would have come by himself until he
// felt it one reaction time before, and tilts no more than his search does.
TEST(Relabel, AsksWhoSearchesToo) {
  const Scene scene = load_scene("by_hand/sharp");
  Policy p = straight_in(kStep);
  p.velocity_mean *= 0.5;  // to be led against it for longer
  TraineeTraits steady = trainee_traits(0.8);
  steady.tremor = steady.hesitation_rate = 0;
  steady.delay = 0.15;
  const Demonstration d = relabelled_trial(scene, p, {0.8, true}, steady.delay, 1, 3);
  const auto person = searching_operator(scene, steady, kStep, [] { return 0.5; });
  Eigen::Index came = 0, touched = 0;
  for (Eigen::Index n = 0; n < d.rows(); ++n) {
    const HandTwist v = person->command(d.observed(n));
    EXPECT_EQ(v.head<3>(), d.velocity.row(n).transpose()) << n;
    EXPECT_EQ(v.tail<2>(), d.tilt_rates.row(n).transpose()) << n;
    came += d.velocity(n, 0) < 0;
    touched += d.velocity(n, 0) >= 0 && n > d.rows() / 2;
  }
  EXPECT_GT(came, 100);
  EXPECT_GT(touched, 10);
}

// What the operator is asked about is what a recording of the policy shows, bit for bit.
TEST(Relabel, ObservesWhatARecordingOfThePolicyShows) {
  const testing::TemporaryFolder folder;
  const Scene scene = load_scene("bench");
  const Policy p = straight_in(1e-3);
  PolicyController controller(p);
  const std::string file = testing::record(scene, folder.path(), 3, &controller);
  const Demonstration recorded = demonstration(read_episode(file), scene, file);
  const Demonstration d = relabelled_trial(scene, p, {0.8}, 0.15, 1, 3);
  EXPECT_EQ(d.outcome, recorded.outcome);
  ASSERT_EQ(d.rows(), recorded.rows());
  for (Eigen::Index n = 0; n < d.rows(); ++n) {
    const Observation &ours = d.observed(n), &theirs = recorded.observed(n);
    EXPECT_EQ(ours.wrench, theirs.wrench) << n;
    EXPECT_EQ(ours.depth, theirs.depth) << n;
    EXPECT_EQ(ours.time, theirs.time) << n;
    EXPECT_EQ(ours.displacement, theirs.displacement) << n;
    EXPECT_EQ(ours.height, theirs.height) << n;
  }
  EXPECT_EQ(d.speed_limit, recorded.speed_limit);
  EXPECT_NE(d.velocity, recorded.velocity);
}

}  // namespace
}  // namespace ferrule
