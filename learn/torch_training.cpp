#include "learn/torch_training.hpp"

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "learn/tensors.hpp"

namespace ferrule::by_libtorch {
namespace {

using torch::Tensor;

constexpr int kSnapshots = 10;  // of a training of all epochs

struct Perceptron {
  std::vector<Tensor> weights, biases;

  Perceptron(std::int64_t inputs, const std::vector<int>& hidden, std::int64_t answers) {
    std::vector<std::int64_t> widths = {inputs};
    widths.insert(widths.end(), hidden.begin(), hidden.end());
    widths.push_back(2 * answers);
    for (std::size_t i = 0; i + 1 < widths.size(); ++i) {
      // Glorot and Bengio 2010; the last layer begins near 0.
      const double gain = i + 2 < widths.size() ? 1.0 : 0.1;
      const double bound = gain * std::sqrt(6.0 / static_cast<double>(widths[i] + widths[i + 1]));
      weights.push_back(
          torch::empty({widths[i + 1], widths[i]}).uniform_(-bound, bound).requires_grad_());
      biases.push_back(torch::zeros({widths[i + 1]}).requires_grad_());
    }
  }

  std::vector<Tensor> parameters() const {
    std::vector<Tensor> all = weights;
    all.insert(all.end(), biases.begin(), biases.end());
    return all;
  }

  Tensor forward(Tensor h) const {
    for (std::size_t i = 0; i + 1 < weights.size(); ++i)
      h = torch::tanh(torch::linear(h, weights[i], biases[i]));
    return torch::linear(h, weights.back(), biases.back());
  }

  Network network() const {
    Network n;
    for (std::size_t i = 0; i < weights.size(); ++i)
      n.push_back({to_matrix(weights[i]), to_vector(biases[i])});
    return n;
  }
};

// Of each row and channel.
Tensor negative_log_likelihood(const Tensor& output, const Tensor& velocity) {
  const std::int64_t answers = velocity.size(-1);
  const Tensor mean = output.narrow(-1, 0, answers);
  const Tensor log_sd = output.narrow(-1, answers, answers).clamp(kLowestLogSd, kHighestLogSd);
  const Tensor error = (velocity - mean) * torch::exp(-log_sd);
  return 0.5 * error * error + log_sd;
}

void begin(std::uint64_t seed) {
  torch::set_num_threads(1);
  torch::manual_seed(seed);
  torch::globalContext().setDeterministicAlgorithms(true, false);
}

using AdamW = torch::optim::AdamW;

// Of an epoch: its losses, and of each demonstration held out the sum over its rows.
struct Losses {
  Epoch mean;
  std::vector<double> held_out;
};

Losses losses(double training, double held_out, const Tensor& of_each) {
  const Tensor each = of_each.to(torch::kFloat64).contiguous();
  const double* first = each.data_ptr<double>();
  return {{training, held_out}, std::vector<double>(first, first + each.numel())};
}

// Keeps the weights of the best epoch by some loss.
struct Best {
  double least = std::numeric_limits<double>::infinity();
  std::optional<Weights> weights{};

  bool better(double loss, const std::function<Weights()>& now) {
    if (!(loss < least)) return false;
    least = loss;
    weights = now();
    return true;
  }
};

// Asked after each step, whether there is to be another.
using GoOn = std::function<bool()>;

// One epoch after the other, until the held-out loss has not fallen for long, or `progress` says so.
// `epoch` trains on all rows once.
TrainedNetwork trained(const std::vector<Tensor>& parameters, const TrainingSettings& settings,
                       const TrainingProgress& progress,
                       const std::function<Losses(AdamW&, const GoOn&)>& epoch,
                       const std::function<Weights()>& weights) {
  torch::optim::AdamWOptions options(settings.learning_rate);
  AdamW optimiser(parameters, options.weight_decay(settings.weight_decay));
  TrainedNetwork result;
  Best best;
  std::vector<Best> without;
  Epoch last{NAN, NAN};
  bool stopped = false;
  const GoOn go_on = [&] {
    stopped |= progress && !progress(result.curve.size(), last);
    return !stopped;
  };
  for (int n = 0; n < settings.epochs; ++n) {
    const double along = static_cast<double>(n) / settings.epochs;
    static_cast<torch::optim::AdamWOptions&>(optimiser.param_groups()[0].options())
        .lr(settings.learning_rate * 0.5 * (1 + std::cos(std::numbers::pi * along)));
    const Losses now = epoch(optimiser, go_on);
    result.curve.push_back(last = now.mean);
    if (kSnapshots * (n + 1) / settings.epochs > kSnapshots * n / settings.epochs)
      result.snapshots.push_back({result.curve.size(), weights()});
    go_on();
    if (best.better(now.mean.held_out_loss, weights)) result.best = result.curve.size() - 1;
    if (now.held_out.size() > 1) without.resize(now.held_out.size());
    for (std::size_t e = 0; e < without.size(); ++e) {
      double others = 0;
      for (std::size_t k = 0; k < now.held_out.size(); ++k)
        if (k != e) others += now.held_out[k];
      without[e].better(others, weights);
    }
    if (stopped || result.curve.size() - result.best > static_cast<std::size_t>(settings.patience))
      break;
  }
  result.weights = best.weights.value_or(Weights{});
  for (const Best& each : without)
    result.chosen_without.push_back(each.weights.value_or(Weights{}));
  return result;
}

// Of all demonstrations, one after the other.
Tensor joined(const std::vector<TrainingRows>& all, Eigen::MatrixXf TrainingRows::*part) {
  std::vector<Tensor> tensors;
  for (const TrainingRows& rows : all) tensors.push_back(to_tensor(rows.*part));
  return torch::cat(tensors);
}

// Episodes side by side: (rows, episodes, channels), those that have ended with nothing told.
struct Episodes {
  Tensor x, v, told;

  explicit Episodes(const std::vector<TrainingRows>& all) {
    Eigen::Index rows = 0;
    for (const TrainingRows& one : all) rows = std::max(rows, one.input.cols());
    const auto count = static_cast<std::int64_t>(all.size());
    x = torch::zeros({rows, count, all.front().input.rows()});
    v = torch::zeros({rows, count, all.front().velocity.rows()});
    told = torch::zeros({rows, count});
    for (std::int64_t e = 0; e < count; ++e) {
      const TrainingRows& one = all[static_cast<std::size_t>(e)];
      const auto put = [&](Tensor& to, const Eigen::MatrixXf& from) {
        to.select(1, e)
            .narrow(0, 0, from.cols())
            .copy_(to_tensor(from).reshape_as(to.select(1, e).narrow(0, 0, from.cols())));
      };
      put(x, one.input);
      put(v, one.velocity);
      put(told, one.told);
    }
  }
};

// A network with a memory, and what it is trained on.
struct Memory {
  const TrainingSettings& settings;
  Episodes train, held;
  torch::nn::GRU gru;
  Perceptron perceptron;
  std::vector<Tensor> parameters;
  Tensor noise;   // of each input
  Tensor varies;  // each answer: 1 where it does; where it is always 0 the smallest error would
                  // outweigh all others

  Memory(const std::vector<TrainingRows>& training, const std::vector<TrainingRows>& held_out,
         const TrainingSettings& chosen)
      : settings(chosen),
        train(training),
        held(held_out),
        gru(torch::nn::GRUOptions(train.x.size(2), chosen.memory)),
        perceptron(chosen.memory, chosen.hidden, train.v.size(2)),
        parameters(perceptron.parameters()),
        noise(torch::full({train.x.size(2)}, settings.motion_noise)),
        varies((train.v.abs().amax({0, 1}) > 0).to(torch::kFloat32)) {
    for (const Tensor& each : gru->parameters()) parameters.push_back(each);
    noise.narrow(0, 0, kWrenchChannels).fill_(settings.input_noise);
    // Each unit begins with another time for which it remembers, of 1 to a window's rows: chrono
    // initialisation (Tallec and Ollivier 2018).
    const torch::NoGradGuard guard;
    const auto weights = gru->named_parameters();
    weights["bias_ih_l0"].fill_(0);
    weights["bias_hh_l0"].fill_(0);
    weights["bias_ih_l0"]
        .narrow(0, settings.memory, settings.memory)
        .uniform_(1, std::max(2, settings.window - 1))
        .log_();
  }

  // Of each row, episode and channel, 0 where the row tells nothing.
  Tensor loss(const Tensor& h, const Tensor& v, const Tensor& told) const {
    return negative_log_likelihood(perceptron.forward(h), v) * varies * told.unsqueeze(2);
  }

  // The losses of a training, and of how many rows.
  struct Sum {
    double loss = 0, rows = 0;
  };
  // Once through `some` of the episodes, window after window. False where it is not to go on.
  bool train_on(const Tensor& some, AdamW& optimiser, const GoOn& go_on, Sum& sum) {
    Tensor h = torch::zeros({1, some.size(0), settings.memory});
    const std::int64_t rows = train.x.size(0);
    for (std::int64_t row = 0; row < rows; row += settings.window) {
      const auto window = [&](const Tensor& all) {
        return all.narrow(0, row, std::min<std::int64_t>(settings.window, rows - row))
            .index_select(1, some);
      };
      const Tensor told = window(train.told);
      const double n = told.sum().item<double>();
      const Tensor x = window(train.x);
      const auto [all_h, last_h] = gru->forward(x + noise * torch::randn_like(x), h.detach());
      h = last_h;
      if (n == 0) continue;
      const Tensor its = loss(all_h, window(train.v), told).sum();
      optimiser.zero_grad();
      (its / n).backward();
      torch::nn::utils::clip_grad_norm_(parameters, 1.0);
      optimiser.step();
      sum.loss += its.item<double>();
      sum.rows += n;
      if (!go_on()) return false;
    }
    return true;
  }

  Losses with_held_out(double training_loss) {
    const torch::NoGradGuard guard;
    const Tensor its = loss(std::get<0>(gru->forward(held.x)), held.v, held.told);
    return losses(training_loss, its.sum().item<double>() / held.told.sum().item<double>(),
                  its.sum(std::vector<std::int64_t>{0, 2}));
  }

  Weights weights() {
    const auto all = gru->named_parameters();
    return {perceptron.network(),
            {to_matrix(all["weight_ih_l0"]), to_matrix(all["weight_hh_l0"]),
             to_vector(all["bias_ih_l0"]), to_vector(all["bias_hh_l0"])}};
  }
};

TrainedNetwork train_perceptron(const std::vector<TrainingRows>& training,
                                const std::vector<TrainingRows>& held_out,
                                const TrainingSettings& settings,
                                const TrainingProgress& progress) {
  const Tensor x = joined(training, &TrainingRows::input),
               v = joined(training, &TrainingRows::velocity),
               x_held = joined(held_out, &TrainingRows::input),
               v_held = joined(held_out, &TrainingRows::velocity);
  std::vector<std::int64_t> rows_held;
  for (const TrainingRows& one : held_out) rows_held.push_back(one.input.cols());
  const Perceptron perceptron(x.size(1), settings.hidden, v.size(1));
  const auto epoch = [&](AdamW& optimiser, const GoOn& go_on) {
    const Tensor order = torch::randperm(x.size(0));
    double loss_sum = 0, rows_seen = 0;
    for (std::int64_t first = 0; first < x.size(0); first += settings.batch) {
      const Tensor rows =
          order.narrow(0, first, std::min<std::int64_t>(settings.batch, x.size(0) - first));
      Tensor input = x.index_select(0, rows);
      input = input + settings.input_noise * torch::randn_like(input);
      const Tensor loss =
          negative_log_likelihood(perceptron.forward(input), v.index_select(0, rows)).sum(1).mean();
      optimiser.zero_grad();
      loss.backward();
      optimiser.step();
      loss_sum += loss.item<double>() * static_cast<double>(rows.size(0));
      rows_seen += static_cast<double>(rows.size(0));
      if (!go_on()) break;
    }
    const torch::NoGradGuard guard;
    const Tensor its = negative_log_likelihood(perceptron.forward(x_held), v_held).sum(1);
    std::vector<Tensor> of_each;
    for (const Tensor& one : its.split_with_sizes(rows_held)) of_each.push_back(one.sum());
    return losses(loss_sum / rows_seen, its.mean().item<double>(), torch::stack(of_each));
  };
  return trained(perceptron.parameters(), settings, progress, epoch,
                 [&] { return Weights{perceptron.network()}; });
}

TrainedNetwork train_memory(const std::vector<TrainingRows>& training,
                            const std::vector<TrainingRows>& held_out,
                            const TrainingSettings& settings, const TrainingProgress& progress) {
  Memory memory(training, held_out, settings);
  const auto epoch = [&](AdamW& optimiser, const GoOn& go_on) {
    const std::int64_t count = memory.train.x.size(1);
    const Tensor order = torch::randperm(count);
    Memory::Sum sum;
    for (std::int64_t first = 0; first < count; first += settings.together) {
      const std::int64_t n = std::min<std::int64_t>(settings.together, count - first);
      if (!memory.train_on(order.narrow(0, first, n), optimiser, go_on, sum)) break;
    }
    return memory.with_held_out(sum.loss / sum.rows);
  };
  return trained(memory.parameters, settings, progress, epoch, [&] { return memory.weights(); });
}

}  // namespace

TrainedNetwork train_network(const std::vector<TrainingRows>& training,
                             const std::vector<TrainingRows>& held_out,
                             const TrainingSettings& settings, std::uint64_t seed,
                             const TrainingProgress& progress) {
  begin(seed);
  const auto train = settings.memory > 0 ? train_memory : train_perceptron;
  return train(training, held_out, settings, progress);
}

}  // namespace ferrule::by_libtorch
