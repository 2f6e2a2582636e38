#include "learn/fit_policy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "insertion/simulated_operator.hpp"
#include "learn/relabel.hpp"
#include "learn/samples.hpp"

namespace ferrule {
namespace {

using Demonstrations = std::vector<const Demonstration*>;

constexpr const char *kEnsemble = "--ensemble", *kDagger = "--dagger",
                     *kNetworkSeed = "--network-seed";  // options
constexpr const char* kAsSplit = "as --seed";
constexpr std::size_t kTrialsPerRound = 10;
constexpr std::uint64_t kFirstTrial = std::uint64_t{1} << 40;  // no recording comes that far

// Slower than this share of the speed limit the hand rests: before it starts, after it has arrived,
// or to think. A policy that learned to rest would do so for ever.
constexpr double kResting = 0.1;

constexpr double kLeastVelocity = 1e-9;  // standard deviation of one that does not vary [m/s]

// Unscaled.
struct RawRows {
  Eigen::MatrixXd input, velocity;  // (inputs, rows), (3, rows)
};

RawRows rows_of(const Demonstrations& set, double reaction, const Policy& policy) {
  std::size_t most = 0;
  for (const Demonstration* d : set) most += d->observations.size();
  RawRows rows{Eigen::MatrixXd(policy.inputs(), most), Eigen::MatrixXd(kVelocity, most)};
  Eigen::Index count = 0;
  for (const Demonstration* d : set) {
    const Eigen::Index stride = rows_per_step(d->period);
    const auto delay = static_cast<Eigen::Index>(std::lround(reaction / d->period));
    const auto spacing =
        static_cast<Eigen::Index>(std::lround(policy.spacing * policy.period / d->period));
    for (Eigen::Index n = 0; n < d->rows(); n += stride) {
      const bool rests = d->velocity.row(n).norm() < kResting * d->speed_limit;
      if (rests || cut_to_limit(*d, n)) continue;
      for (int i = 0; i < policy.inputs(); ++i) {
        const ObservationChannel& channel = kPolicyInputs[policy.channel(i)];
        const bool past = channel.policy == PolicyInput::past;
        rows.input(i, count) =
            channel.value(d->observed(past ? n - delay - i / kPastChannels * spacing : n));
      }
      rows.velocity.col(count) = d->velocity.row(n);
      ++count;
    }
  }
  rows.input.conservativeResize(Eigen::NoChange, count);
  rows.velocity.conservativeResize(Eigen::NoChange, count);
  return rows;
}

struct MeanAndSd {
  double mean, sd;
};
MeanAndSd spread(const Eigen::RowVectorXd& values) {
  const double mean = values.mean();
  return {mean, std::sqrt((values.array() - mean).square().mean())};
}

void set_scales(Policy& policy, const RawRows& rows) {
  // From the inputs of now: the first of the past, and those after it.
  for (int i = 0; i < policy.inputs(); ++i) {
    if (i >= kPastChannels && i < kPastChannels * policy.samples) continue;
    const std::size_t channel = policy.channel(i);
    const MeanAndSd s = spread(rows.input.row(i));
    policy.mean[channel] = s.mean;
    policy.scale[channel] = s.sd > kPolicyInputs[channel].negligible ? s.sd : 1;
  }
  for (int i = 0; i < kVelocity; ++i) {
    const MeanAndSd s = spread(rows.velocity.row(i));
    policy.velocity_mean[i] = s.mean;
    policy.velocity_scale[i] = s.sd > kLeastVelocity ? s.sd : 0;
  }
}

Eigen::MatrixXf scaled_inputs(const Policy& policy, const Eigen::MatrixXd& inputs) {
  Eigen::MatrixXf z(inputs.rows(), inputs.cols());
  for (int i = 0; i < policy.inputs(); ++i) {
    const std::size_t channel = policy.channel(i);
    z.row(i) =
        ((inputs.row(i).array() - policy.mean[channel]) / policy.scale[channel]).cast<float>();
  }
  return z;
}

TrainingRows scaled(const Policy& policy, const RawRows& rows) {
  TrainingRows s{scaled_inputs(policy, rows.input),
                 Eigen::MatrixXf::Zero(kVelocity, rows.velocity.cols())};
  for (int i = 0; i < kVelocity; ++i)
    if (policy.velocity_scale[i] > 0)
      s.velocity.row(i) =
          ((rows.velocity.row(i).array() - policy.velocity_mean[i]) / policy.velocity_scale[i])
              .cast<float>();
  return s;
}

double root_mean_square(const Policy& policy, const RawRows& rows) {
  const Eigen::MatrixXd error = policy_velocities(policy, rows.input) - rows.velocity;
  return std::sqrt(error.squaredNorm() / static_cast<double>(error.cols()));
}

// What is known before the first training.
PolicyFit begun(const DemonstrationSet& set, const PolicySettings& settings,
                const Demonstrations& training, const Demonstrations& held_out) {
  PolicyFit fit;
  PolicyFile& f = fit.file;
  f.policy.samples = settings.samples;
  f.policy.spacing = std::max(1, static_cast<int>(std::lround(settings.spacing / f.policy.period)));
  f.policy.speed_limit = set.speed_scale;
  f.reaction_time = reaction_time(training);
  f.input_noise = settings.training.input_noise;
  f.weight_decay = settings.training.weight_decay;
  f.trained_on = trained_on(set, training, held_out, settings.seed);
  return fit;
}

// Trains all members anew on the rows, which the policy's scales are of.
void train_members(PolicyFit& fit, const RawRows& train, const RawRows& test,
                   const PolicySettings& settings, std::size_t round,
                   const PolicyProgress& progress) {
  PolicyFile& f = fit.file;
  const auto epochs = static_cast<std::size_t>(settings.training.epochs);
  const TrainingRows train_scaled = scaled(f.policy, train), test_scaled = scaled(f.policy, test);
  f.policy.members.clear();
  f.members.clear();
  fit.curves.clear();
  for (std::size_t m = 0; m < settings.members; ++m) {
    const std::size_t before = (round * settings.members + m) * epochs;
    bool stopped = false;
    const TrainedNetwork trained = train_network(
        train_scaled, test_scaled, settings.training,
        settings.network_seed.value_or(settings.seed) + m, [&](std::size_t epoch, const Epoch& e) {
          stopped = progress && !progress(before + epoch, e);
          return !stopped;
        });
    if (trained.network.empty())
      throw BadInput("the training diverged: its loss was never a finite number");
    f.policy.members.push_back(trained.network);
    f.members.push_back({static_cast<int>(trained.curve.size()), static_cast<int>(trained.best + 1),
                         trained.curve[trained.best].training_loss,
                         trained.curve[trained.best].held_out_loss});
    fit.curves.push_back(trained.curve);
    f.trained_on.partial |= stopped;
    if (stopped) return;
  }
}

// Skill of each simulated operator who demonstrated. Throws BadInput where there is none.
std::vector<double> teachers(const Demonstrations& training) {
  std::vector<double> skills;
  for (const Demonstration* d : training)
    if (const auto skill = simulated_skill(d->operator_)) skills.push_back(*skill);
  if (skills.empty())
    throw BadInput(
        "--dagger: asks the simulated operator who demonstrated what he would have done; the "
        "demonstrations are by \"" +
        training.front()->operator_ + "\"");
  return skills;
}

// A round of DAgger: appends to `met` the states that the policy met, with the answers of the
// operators who demonstrated, in turn.
DaggerRound let_it_insert(const DemonstrationSet& set, const PolicyFile& f,
                          const std::vector<double>& skills, std::uint64_t seed, std::size_t round,
                          std::vector<Demonstration>& met) {
  DaggerRound now;
  for (std::size_t k = 0; k < kTrialsPerRound; ++k) {
    const std::string what = "a scene of the episodes";
    const Scene scene =
        parse_scene(parse_json(set.documents[k % set.documents.size()], what), what);
    const std::uint64_t trial = round * kTrialsPerRound + k;
    met.push_back(relabelled_trial(scene, f.policy, skills[trial % skills.size()], f.reaction_time,
                                   seed, kFirstTrial + trial));
    ++now.trials;
    now.inserted += met.back().outcome == Outcome::inserted;
  }
  return now;
}

std::string text_of(const PolicyFile& f, std::size_t unsuccessful) {
  std::string text = fmt::format("{:<8} {:>7} {:>6} {:>14} {:>14}\n", "network", "epochs", "best",
                                 "loss", "held out");
  for (std::size_t m = 0; m < f.members.size(); ++m)
    text += fmt::format("{:<8} {:>7} {:>6} {:>14.4f} {:>14.4f}\n", m + 1, f.members[m].epochs,
                        f.members[m].best_epoch, f.members[m].training_loss,
                        f.members[m].held_out_loss);
  for (const DaggerRound& r : f.dagger)
    text += fmt::format("round: {} of {} inserted, {} rows added, held-out loss then {:.4f}\n",
                        r.inserted, r.trials, r.rows, r.held_out_loss);
  text += fmt::format("reaction time {:.2f} s (identified, not imitated)\n", f.reaction_time);
  text += fmt::format("{} training episodes{}, {} held out, {} unsuccessful left out, {} rows\n",
                      f.trained_on.episodes.size(),
                      f.trained_on.rollouts
                          ? fmt::format(" and {} rollouts labelled by the simulated operator",
                                        f.trained_on.rollouts)
                          : std::string(),
                      f.trained_on.held_out.size(), unsuccessful, f.trained_on.rows);
  return text + fmt::format("velocity residual {:.4g} mm/s, held out {:.4g} mm/s (hand)\n",
                            1e3 * f.residual, 1e3 * f.held_out_residual);
}

Learned learn_policy(const DemonstrationSet& set, const LearnerSettings& chosen,
                     const LearnerProgress& progress) {
  PolicySettings settings;
  settings.members = chosen.number(kEnsemble);
  settings.dagger_rounds = chosen.number(kDagger);
  settings.seed = chosen.seed;
  if (chosen.options.at(kNetworkSeed) != kAsSplit)
    settings.network_seed = std::stoull(chosen.options.at(kNetworkSeed));
  const std::size_t all = (settings.dagger_rounds + 1) * settings.members *
                          static_cast<std::size_t>(settings.training.epochs);
  const PolicyFit fit = fit_policy(set, settings, [&](std::size_t done, const Epoch& e) {
    return !progress || progress(done, all,
                                 fmt::format("  loss {:.3f}, held out {:.3f}", e.training_loss,
                                             e.held_out_loss));
  });
  return {fit.file, text_of(fit.file, set.unsuccessful), fit.curves};
}

}  // namespace

Eigen::MatrixXd policy_velocities(const Policy& policy, const Eigen::MatrixXd& inputs) {
  const Eigen::MatrixXf z = scaled_inputs(policy, inputs);
  Eigen::MatrixXd mean = Eigen::MatrixXd::Zero(kVelocity, inputs.cols());
  for (const Network& network : policy.members) {
    Eigen::MatrixXf h = z;
    for (std::size_t i = 0; i < network.size(); ++i) {
      h = (network[i].weight * h).colwise() + network[i].bias;
      if (i + 1 < network.size()) h = h.array().tanh();
    }
    mean += h.topRows<kVelocity>().cast<double>() / static_cast<double>(policy.members.size());
  }
  return (policy.velocity_scale.asDiagonal() * mean).colwise() + policy.velocity_mean;
}

PolicyFit fit_policy(const DemonstrationSet& set, const PolicySettings& settings,
                     const PolicyProgress& progress) {
  refuse_too_few(set);
  auto [training, held_out] = split(set.demonstrations, settings.seed);
  std::vector<double> skills;
  if (settings.dagger_rounds > 0) skills = teachers(training);
  PolicyFit fit = begun(set, settings, training, held_out);
  PolicyFile& f = fit.file;
  const RawRows test = rows_of(held_out, f.reaction_time, f.policy);
  std::vector<Demonstration> met;  // by the policy, relabelled
  met.reserve(settings.dagger_rounds * kTrialsPerRound);
  RawRows train;
  for (std::size_t round = 0;; ++round) {
    train = rows_of(training, f.reaction_time, f.policy);
    if (train.input.cols() < Eigen::Index{kFewestRows} || test.input.cols() == 0)
      throw BadInput(fmt::format("too little data: {} rows in steps of 10 ms; {} are needed",
                                 train.input.cols(), kFewestRows));
    const auto rows = static_cast<std::size_t>(train.input.cols());
    if (round > 0) f.dagger.back().rows = rows - f.trained_on.rows;
    f.trained_on.rows = rows;
    set_scales(f.policy, train);
    train_members(fit, train, test, settings, round, progress);
    if (round > 0)
      for (const MemberTraining& m : f.members)
        f.dagger.back().held_out_loss += m.held_out_loss / static_cast<double>(f.members.size());
    if (round == settings.dagger_rounds || f.trained_on.partial) break;
    const std::size_t before = met.size();
    f.dagger.push_back(let_it_insert(set, f, skills, settings.seed, round, met));
    f.trained_on.rollouts = met.size();
    for (std::size_t k = before; k < met.size(); ++k) training.push_back(&met[k]);
  }
  f.residual = root_mean_square(f.policy, train);
  f.held_out_residual = root_mean_square(f.policy, test);
  return fit;
}

Learner policy_learner() {
  return {
      .name = "policy",
      .method = "torch",
      .options = {{kEnsemble, "With torch: how many networks", "1", {}, 1, 100},
                  {kNetworkSeed,
                   "With torch: seed of the networks' first weights and batches, apart from that "
                   "of the split",
                   kAsSplit,
                   {},
                   0,
                   LearnerOption::kSeed},
                  {kDagger,
                   "With torch: rounds of letting the policy insert and asking the simulated "
                   "operator what it would have done",
                   "0",
                   {},
                   0,
                   100}},
      .variants = {{"torch", "torch", {}},
                   {"ensemble", "torch, ensemble of 5", {{kEnsemble, "5"}}},
                   {"dagger", "torch, DAgger 3 rounds", {{kDagger, "3"}}}},
      .files =
          [](const std::string& file) {
            return std::vector{file, weights_file(file, "")};
          },
      .learn = learn_policy};
}

}  // namespace ferrule
