#include "learn/fit_policy.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "controller/searching_operator.hpp"
#include "insertion/simulated_operator.hpp"
#include "learn/choose_weights.hpp"
#include "learn/policy_rows.hpp"
#include "learn/relabel.hpp"
#include "learn/samples.hpp"

namespace ferrule {
namespace {

using Demonstrations = std::vector<const Demonstration*>;

constexpr const char *kEnsemble = "--ensemble", *kDagger = "--dagger",
                     *kNetworkSeed = "--network-seed", *kNetwork = "--network",
                     *kSamples = "--samples";  // options
constexpr const char *kPerceptron = "perceptron", *kGru = "gru";
constexpr const char *kAsSplit = "as --seed", *kSamplesOfNetwork = "3, of gru 1";
constexpr std::size_t kTrialsPerRound = 10;
constexpr std::uint64_t kFirstTrial = std::uint64_t{1} << 40;  // no recording comes that far

// What is known before the first training.
PolicyFit begun(const DemonstrationSet& set, const PolicySettings& settings,
                const Demonstrations& training, const Demonstrations& held_out) {
  PolicyFit fit;
  PolicyFile& f = fit.file;
  f.policy.samples = settings.samples;
  f.policy.spacing = std::max(1, static_cast<int>(std::lround(settings.spacing / f.policy.period)));
  f.policy.speed_limit = set.speed_scale;
  if (settings.training.memory > 0) f.policy.memories.resize(1);  // until they are trained
  if (std::any_of(training.begin(), training.end(),
                  [](const Demonstration* d) { return !d->tilt_rates.isZero(0); }))
    f.policy.velocity_mean = f.policy.velocity_scale = PolicyTwist::Zero(kTwist);
  f.reaction_time = reaction_time(training);
  f.input_noise = settings.training.input_noise;
  f.weight_decay = settings.training.weight_decay;
  f.trained_on = trained_on(set, training, held_out, settings.seed);
  return fit;
}

// Of DAgger; of a training without it the only one.
struct Round {
  PolicyFit fit;
  std::vector<PolicyRows> train;
  // For each demonstration held out the policy of the epochs that the others chose, without members
  // if there are none.
  std::vector<Policy> chosen_without;
};

// In the rounds before.
std::size_t epochs_before(const PolicySettings& settings, std::size_t round) {
  return round * settings.members * static_cast<std::size_t>(settings.training.epochs);
}

// Trains all members anew on the round's rows, which the policy's scales are of.
void train_members(Round& now, const std::vector<PolicyRows>& test, const DemonstrationSet& set,
                   const PolicySettings& settings, std::size_t round,
                   const PolicyProgress& progress) {
  auto& [fit, train, chosen_without] = now;
  PolicyFile& f = fit.file;
  const auto epochs = static_cast<std::size_t>(settings.training.epochs);
  const std::vector<TrainingRows> train_scaled = scaled(f.policy, train),
                                  test_scaled = scaled(f.policy, test);
  f.policy.memories.clear();
  f.policy.members.clear();
  chosen_without.assign(test.size(), f.policy);
  f.members.clear();
  fit.curves.clear();
  for (std::size_t m = 0; m < settings.members; ++m) {
    const std::size_t before = epochs_before(settings, round) + m * epochs;
    bool stopped = false;
    const auto told = [&](std::size_t epoch, const Epoch& e) {
      stopped |= progress && !progress(before + epoch, e);
      return !stopped;
    };
    const std::uint64_t seed = settings.network_seed.value_or(settings.seed) + m;
    TrainedNetwork trained =
        train_network(train_scaled, test_scaled, settings.training, seed, told);
    TriedWeights best;
    if (settings.rollouts > 0 && !stopped)
      best = choose_weights(trained.snapshots, f.policy, set.undrawn_documents, settings.rollouts,
                            seed, [&] {
                              return told(trained.curve.size(), {NAN, NAN});
                            });
    if (best.tried) {  // without a word of those held out
      trained.weights = best.tried->weights;
      trained.best = best.tried->epochs - 1;
      trained.chosen_without.assign(test.size(), trained.weights);
    }
    f.trained_on.partial |= stopped;
    if (stopped && m > 0) return;
    if (trained.weights.network.empty())
      throw BadInput("the training diverged: its loss was never a finite number");
    add_member(f.policy, trained.weights);
    for (std::size_t e = 0; e < trained.chosen_without.size(); ++e)
      add_member(chosen_without[e], trained.chosen_without[e]);
    f.members.push_back({static_cast<int>(trained.curve.size()), static_cast<int>(trained.best + 1),
                         trained.curve[trained.best].training_loss,
                         trained.curve[trained.best].held_out_loss,
                         best.tried ? settings.rollouts : 0, best.inserted});
    fit.curves.push_back(trained.curve);
    if (stopped) return;
  }
}

// Of the error of the translation on the rows of each demonstration, by the policy for it, without
// the speed limit [m/s]; NaN where one has no members.
double root_mean_square(const std::vector<PolicyRows>& rows,
                        const std::function<const Policy&(std::size_t)>& policy_for) {
  double squares = 0;
  for (std::size_t e = 0; e < rows.size(); ++e) {
    if (policy_for(e).members.empty()) return NAN;
    squares += squared_error(policy_for(e), rows[e]);
  }
  return std::sqrt(squares / static_cast<double>(count(rows)));
}

// The simulated operators who demonstrated. Throws BadInput where there is none.
std::vector<SimulatedOperator> teachers(const Demonstrations& training) {
  std::vector<SimulatedOperator> found;
  for (const Demonstration* d : training)
    if (const auto simulated = SimulatedOperator::named(d->operator_)) found.push_back(*simulated);
  if (found.empty())
    throw BadInput(
        "--dagger: asks the simulated operator who demonstrated what he would have done; the "
        "demonstrations are by \"" +
        training.front()->operator_ + "\"");
  return found;
}

// A round of DAgger: appends to `met` the states that the policy met, with the answers of the
// operators who demonstrated, in turn; fewer of them where it is not to go on.
DaggerRound let_it_insert(const DemonstrationSet& set, const PolicyFile& f,
                          const std::vector<SimulatedOperator>& teachers, std::uint64_t seed,
                          std::size_t round, std::vector<Demonstration>& met,
                          const std::function<bool()>& go_on) {
  DaggerRound now;
  for (std::size_t k = 0; k < kTrialsPerRound && go_on(); ++k) {
    const std::string what = "a scene of the episodes";
    const Scene scene = parse_scene(set.undrawn_documents[k % set.undrawn_documents.size()], what);
    const std::uint64_t trial = round * kTrialsPerRound + k;
    met.push_back(relabelled_trial(scene, f.policy, teachers[trial % teachers.size()],
                                   f.reaction_time, seed, kFirstTrial + trial));
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
  for (const MemberTraining& m : f.members)
    if (m.rollouts > 0)
      text += fmt::format("epoch {} chosen by rollouts: {} of {} inserted\n", m.best_epoch,
                          m.inserted, m.rollouts);
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
  text += fmt::format("velocity residual {:.4g} mm/s, ", 1e3 * f.residual);
  if (std::isnan(f.held_out_residual)) return text + "held out unknown: one chose the epoch\n";
  const bool by_rollouts = f.members.front().rollouts > 0;
  return text + fmt::format("held out {:.4g} mm/s (hand){}\n", 1e3 * f.held_out_residual,
                            by_rollouts ? "" : ", each by the weights that the others chose");
}

Learned learn_policy(const DemonstrationSet& set, const LearnerSettings& chosen,
                     const LearnerProgress& progress) {
  PolicySettings settings;
  const bool remembers = chosen.options.at(kNetwork) == kGru;
  if (remembers) settings = memory_settings();
  const std::string& samples = chosen.options.at(kSamples);
  if (samples != kSamplesOfNetwork) {
    if (remembers) throw BadInput("--samples: a network that remembers sees one moment");
    settings.samples = std::stoi(samples);
  }
  settings.members = chosen.number(kEnsemble);
  settings.dagger_rounds = chosen.number(kDagger);
  settings.seed = chosen.seed;
  if (chosen.options.at(kNetworkSeed) != kAsSplit)
    settings.network_seed = std::stoull(chosen.options.at(kNetworkSeed));
  const std::size_t all = epochs_before(settings, settings.dagger_rounds + 1);
  const PolicyFit fit = fit_policy(set, settings, [&](std::size_t done, const Epoch& e) {
    const std::string note =
        std::isnan(e.training_loss)
            ? std::string()
            : fmt::format("  loss {:.3f}, held out {:.3f}", e.training_loss, e.held_out_loss);
    return !progress || progress(done, all, note);
  });
  return {fit.file, text_of(fit.file, set.unsuccessful), fit.curves};
}

}  // namespace

PolicySettings memory_settings() {
  PolicySettings s;
  s.samples = 1;
  s.spacing = 0.02;
  s.training.memory = 64;
  s.training.hidden = {64};
  s.training.epochs = s.training.patience = 150;
  s.training.learning_rate = 3e-3;
  s.rollouts = 200;
  return s;
}

PolicyFit fit_policy(const DemonstrationSet& set, const PolicySettings& settings,
                     const PolicyProgress& progress) {
  refuse_too_few(set);
  auto [training, held_out] = split(set.demonstrations, settings.seed);
  std::vector<SimulatedOperator> asked;
  if (settings.dagger_rounds > 0) asked = teachers(training);
  Round now{begun(set, settings, training, held_out), {}, {}}, before;
  PolicyFile& f = now.fit.file;
  const std::vector<PolicyRows> test = policy_rows(held_out, f.reaction_time, f.policy);
  std::vector<Demonstration> met;  // by the policy, relabelled
  met.reserve(settings.dagger_rounds * kTrialsPerRound);
  for (std::size_t round = 0;; ++round) {
    now.train = policy_rows(training, f.reaction_time, f.policy);
    if (count(now.train) < Eigen::Index{kFewestRows} || count(test) == 0)
      throw BadInput(fmt::format("too little data: {} rows in steps of 10 ms; {} are needed",
                                 count(now.train), kFewestRows));
    const auto rows = static_cast<std::size_t>(count(now.train));
    if (round > 0) f.dagger.back().rows = rows - f.trained_on.rows;
    f.trained_on.rows = rows;
    set_scales(f.policy, now.train);
    train_members(now, test, set, settings, round, progress);
    if (f.trained_on.partial && round > 0) break;
    for (const MemberTraining& m : f.members)
      if (round > 0)
        f.dagger.back().held_out_loss += m.held_out_loss / static_cast<double>(f.members.size());
    if (round == settings.dagger_rounds || f.trained_on.partial) break;
    before = now;
    const std::size_t first = met.size(), epochs = epochs_before(settings, round + 1);
    f.dagger.push_back(let_it_insert(set, f, asked, settings.seed, round, met, [&] {
      f.trained_on.partial |= progress && !progress(epochs, {NAN, NAN});
      return !f.trained_on.partial;
    }));
    if (f.trained_on.partial) break;
    f.trained_on.rollouts = met.size();
    for (std::size_t k = first; k < met.size(); ++k) training.push_back(&met[k]);
  }
  if (f.trained_on.partial && !before.train.empty()) {
    now = before;
    f.trained_on.partial = true;
  }
  f.residual = root_mean_square(now.train, [&](std::size_t) -> const Policy& { return f.policy; });
  f.held_out_residual =
      root_mean_square(test, [&](std::size_t e) -> const Policy& { return now.chosen_without[e]; });
  return now.fit;
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
                  {kNetwork,
                   "With torch: gru remembers, and takes in its own motion; perceptron sees the "
                   "last moments",
                   kPerceptron,
                   {kPerceptron, kGru}},
                  {kSamples,
                   "With torch: at how many moments, 40 ms apart, a perceptron sees the wrench",
                   kSamplesOfNetwork,
                   {},
                   1,
                   100},
                  {kDagger,
                   "With torch: rounds of letting the policy insert and asking the simulated "
                   "operator what it would have done",
                   "0",
                   {},
                   0,
                   100}},
      .variants = {{"torch", "torch", {}},
                   {"ensemble", "torch, ensemble of 5", {{kEnsemble, "5"}}},
                   {"dagger", "torch, DAgger 3 rounds", {{kDagger, "3"}}},
                   {"gru", "torch, GRU", {{kNetwork, kGru}}}},
      .memoryless = {{kNetwork, kPerceptron}, {kSamples, "1"}},
      .files =
          [](const std::string& file) {
            return std::vector{file, weights_file(file, "")};
          },
      .learn = learn_policy};
}

}  // namespace ferrule
