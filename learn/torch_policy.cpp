#include "learn/torch_policy.hpp"

#include <torch/script.h>
#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "sim/base/error.hpp"

namespace ferrule {
namespace {

using torch::Tensor;

// (rows, columns) of a column-major matrix (columns, rows).
Tensor to_tensor(const Eigen::MatrixXf& m) {
  return torch::from_blob(const_cast<float*>(m.data()), {m.cols(), m.rows()}, torch::kFloat32)
      .clone();
}

Eigen::MatrixXf to_matrix(const Tensor& tensor) {
  using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  const Tensor t = tensor.detach().contiguous();
  return Eigen::Map<const RowMajor>(t.data_ptr<float>(), t.size(0), t.size(1));
}

Eigen::VectorXf to_vector(const Tensor& tensor) {
  const Tensor t = tensor.detach().contiguous();
  return Eigen::Map<const Eigen::VectorXf>(t.data_ptr<float>(), t.size(0));
}

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

// One epoch after the other, until the held-out loss has not fallen for long, or `progress` says so.
// `epoch` trains on all rows once, and `keep` stores the weights of the best so far.
TrainedNetwork trained(const std::vector<Tensor>& parameters, const TrainingSettings& settings,
                       const TrainingProgress& progress, const std::function<Epoch(AdamW&)>& epoch,
                       const std::function<void(TrainedNetwork&)>& keep) {
  torch::optim::AdamWOptions options(settings.learning_rate);
  AdamW optimiser(parameters, options.weight_decay(settings.weight_decay));
  TrainedNetwork result;
  double least = std::numeric_limits<double>::infinity();
  for (int n = 0; n < settings.epochs; ++n) {
    const double along = static_cast<double>(n) / settings.epochs;
    static_cast<torch::optim::AdamWOptions&>(optimiser.param_groups()[0].options())
        .lr(settings.learning_rate * 0.5 * (1 + std::cos(std::numbers::pi * along)));
    const Epoch now = epoch(optimiser);
    result.curve.push_back(now);
    const bool go_on = !progress || progress(result.curve.size(), now);
    if (now.held_out_loss < least) {
      least = now.held_out_loss;
      result.best = result.curve.size() - 1;
      keep(result);
    }
    if (!go_on || result.curve.size() - result.best > static_cast<std::size_t>(settings.patience))
      break;
  }
  return result;
}

TrainedNetwork train(const TrainingRows& training, const TrainingRows& held_out,
                     const TrainingSettings& settings, std::uint64_t seed,
                     const TrainingProgress& progress) {
  begin(seed);
  const Tensor x = to_tensor(training.input), v = to_tensor(training.velocity);
  const Tensor x_held = to_tensor(held_out.input), v_held = to_tensor(held_out.velocity);
  const Perceptron perceptron(x.size(1), settings.hidden, v.size(1));
  const auto epoch = [&](AdamW& optimiser) -> Epoch {
    const Tensor order = torch::randperm(x.size(0));
    double loss_sum = 0;
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
    }
    const torch::NoGradGuard guard;
    return {
        loss_sum / static_cast<double>(x.size(0)),
        negative_log_likelihood(perceptron.forward(x_held), v_held).sum(1).mean().item<double>()};
  };
  return trained(perceptron.parameters(), settings, progress, epoch,
                 [&](TrainedNetwork& best) { best.network = perceptron.network(); });
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

TrainedNetwork train_with_memory(const std::vector<TrainingRows>& training,
                                 const std::vector<TrainingRows>& held_out,
                                 const TrainingSettings& settings, std::uint64_t seed,
                                 const TrainingProgress& progress) {
  begin(seed);
  const Episodes train(training), held(held_out);
  torch::nn::GRU gru(torch::nn::GRUOptions(train.x.size(2), settings.memory));
  {
    // Each unit begins with another time for which it remembers, of 1 to a window's rows: chrono
    // initialisation (Tallec and Ollivier 2018).
    const torch::NoGradGuard guard;
    const auto biases = gru->named_parameters();
    biases["bias_ih_l0"].fill_(0);
    biases["bias_hh_l0"].fill_(0);
    biases["bias_ih_l0"]
        .narrow(0, settings.memory, settings.memory)
        .uniform_(1, std::max(2, settings.window - 1))
        .log_();
  }
  const Perceptron perceptron(settings.memory, settings.hidden, train.v.size(2));
  std::vector<Tensor> parameters = perceptron.parameters();
  for (const Tensor& each : gru->parameters()) parameters.push_back(each);
  // Sum of the losses of the rows that tell something, over the channels that vary: where one is
  // always 0 the smallest error would outweigh all others.
  const Tensor varies = (train.v.abs().amax({0, 1}) > 0).to(torch::kFloat32);
  const auto loss_of = [&](const Tensor& h, const Tensor& v, const Tensor& told) {
    return (negative_log_likelihood(perceptron.forward(h), v) * varies * told.unsqueeze(2)).sum();
  };
  Tensor noise = torch::zeros({train.x.size(2)});
  noise.narrow(0, 0, kWrenchChannels).fill_(settings.input_noise);

  const auto epoch = [&](AdamW& optimiser) -> Epoch {
    const std::int64_t rows = train.x.size(0), count = train.x.size(1);
    const Tensor order = torch::randperm(count);
    double loss_sum = 0;
    for (std::int64_t first = 0; first < count; first += settings.together) {
      const Tensor some =
          order.narrow(0, first, std::min<std::int64_t>(settings.together, count - first));
      Tensor h = torch::zeros({1, some.size(0), settings.memory});
      for (std::int64_t row = 0; row < rows; row += settings.window) {
        const auto window = [&](const Tensor& all) {
          return all.narrow(0, row, std::min<std::int64_t>(settings.window, rows - row))
              .index_select(1, some);
        };
        const Tensor told = window(train.told);
        const double n = told.sum().item<double>();
        if (n == 0) continue;
        Tensor x = window(train.x);
        x = x + noise * torch::randn_like(x);
        const auto [all_h, last_h] = gru->forward(x, h.detach());
        h = last_h;
        const Tensor loss = loss_of(all_h, window(train.v), told);
        optimiser.zero_grad();
        (loss / n).backward();
        torch::nn::utils::clip_grad_norm_(parameters, 1.0);
        optimiser.step();
        loss_sum += loss.item<double>();
      }
    }
    const torch::NoGradGuard guard;
    const double held_loss =
        loss_of(std::get<0>(gru->forward(held.x)), held.v, held.told).item<double>();
    return {loss_sum / train.told.sum().item<double>(), held_loss / held.told.sum().item<double>()};
  };
  return trained(parameters, settings, progress, epoch, [&](TrainedNetwork& best) {
    best.network = perceptron.network();
    const auto weights = gru->named_parameters();
    best.memory = {to_matrix(weights["weight_ih_l0"]), to_matrix(weights["weight_hh_l0"]),
                   to_vector(weights["bias_ih_l0"]), to_vector(weights["bias_hh_l0"])};
  });
}

Tensor constant(const Eigen::VectorXd& values) {
  return torch::from_blob(const_cast<double*>(values.data()), {values.size()}, torch::kFloat64)
      .clone();
}

std::string script(const Policy& policy) {
  torch::jit::Module module("ferrule_policy");
  Eigen::VectorXd mean(policy.inputs()), scale(policy.inputs());
  for (int i = 0; i < policy.inputs(); ++i) {
    mean[i] = policy.mean[policy.channel(i)];
    scale[i] = policy.scale[policy.channel(i)];
  }
  module.register_buffer("mean", constant(mean));
  module.register_buffer("scale", constant(scale));
  module.register_buffer("velocity_mean", constant(policy.velocity_mean));
  module.register_buffer("velocity_scale", constant(policy.velocity_scale));
  const bool remembers = !policy.memories.empty();
  std::ostringstream code;
  code.precision(17);
  code << "def forward(self, inputs" << (remembers ? ", memory" : "") << "):\n"
       << "    z = ((inputs - self.mean) / self.scale).float()\n"
       << "    means = []\n"
       << "    variances = []\n"
       << (remembers ? "    remembered = []\n" : "");
  // Eigen's columns are the rows of the transpose.
  const auto parameter = [&](const std::string& name, const Tensor& value) {
    module.register_parameter(name, value, false);
    return "self." + name;
  };
  const auto linear = [&](const std::string& at, const Eigen::MatrixXf& weight,
                          const Eigen::VectorXf& bias, const std::string& in) {
    const std::string w = parameter("weight_" + at, to_tensor(weight).t().contiguous());
    const std::string b = parameter("bias_" + at, to_tensor(bias).view({-1}));
    return "torch.addmm(" + b + ", " + in + ", " + w + ".t())";
  };
  const int answers = policy.answers();
  for (std::size_t m = 0; m < policy.members.size(); ++m) {
    const Network& network = policy.members[m];
    const std::string member = std::to_string(m);
    code << "    h = z\n";
    if (remembers) {
      const Gru& gru = policy.memories[m];
      code << "    old = memory[" << member << "]\n"
           << "    a_r, a_u, a_n = torch.chunk("
           << linear("input_" + member, gru.input_weight, gru.input_bias, "z") << ", 3, 1)\n"
           << "    c_r, c_u, c_n = torch.chunk("
           << linear("memory_" + member, gru.memory_weight, gru.memory_bias, "old") << ", 3, 1)\n"
           << "    u = torch.sigmoid(a_u + c_u)\n"
           << "    h = (1 - u) * torch.tanh(a_n + torch.sigmoid(a_r + c_r) * c_n) + u * old\n"
           << "    remembered.append(h)\n";
    }
    for (std::size_t i = 0; i < network.size(); ++i) {
      const std::string layer =
          linear(member + "_" + std::to_string(i), network[i].weight, network[i].bias, "h");
      code << "    h = " << (i + 1 < network.size() ? "torch.tanh(" + layer + ")" : layer) << "\n";
    }
    code << "    means.append(h[:, :" << answers << "].double())\n"
         << "    variances.append(torch.exp(2 * torch.clamp(h[:, " << answers << ":].double(), "
         << kLowestLogSd << ", " << kHighestLogSd << ")))\n";
  }
  code
      << "    stacked = torch.stack(means)\n"
      << "    mean = stacked.mean(0)\n"
      << "    velocity = self.velocity_mean + self.velocity_scale * mean\n"
      << "    motion = velocity[:, :3]\n"
      << "    speed = (motion * motion).sum([1], True).sqrt()\n"
      << "    limit = " << policy.speed_limit << "\n"
      << "    motion = motion * torch.where(speed > limit, limit / speed, torch.ones_like(speed))\n"
      << "    velocity = torch.cat((motion, velocity[:, 3:]), 1)\n"
      << "    deviation = self.velocity_scale * torch.stack(variances).mean(0).sqrt()\n"
      << "    among = ((stacked - mean) ** 2).mean(0).sqrt()\n"
      << "    return velocity, deviation, self.velocity_scale * among"
      << (remembers ? ", torch.stack(remembered)" : "") << "\n";
  module.define(code.str());
  std::ostringstream bytes;
  module.save(bytes);
  return bytes.str();
}

Eigen::MatrixXd run(const std::string& bytes, const Eigen::MatrixXd& inputs,
                    std::array<int, 2> memory) {
  torch::set_num_threads(1);
  const torch::NoGradGuard guard;
  std::istringstream stream(bytes);
  torch::jit::Module module = torch::jit::load(stream);
  const Tensor x = torch::from_blob(const_cast<double*>(inputs.data()),
                                    {inputs.cols(), inputs.rows()}, torch::kFloat64);
  std::vector<Tensor> answers;  // each (rows, 3 answers)
  const auto add = [&](const torch::jit::IValue& answer) {
    const auto& e = answer.toTuple()->elements();
    answers.push_back(torch::cat({e[0].toTensor(), e[1].toTensor(), e[2].toTensor()}, 1));
    return e.back().toTensor();
  };
  if (memory[0] == 0) {
    add(module.forward({x}));
  } else {
    Tensor remembered = torch::zeros({memory[0], 1, memory[1]});
    for (std::int64_t row = 0; row < x.size(0); ++row)
      remembered = add(module.forward({x.narrow(0, row, 1), remembered}));
  }
  const Tensor all = torch::cat(answers).contiguous();
  return Eigen::Map<const Eigen::MatrixXd>(all.data_ptr<double>(), all.size(1), all.size(0));
}

// One line of what libtorch says: the reason below a trace of the script, or else the first, for
// where it was thrown comes after it.
std::string reason(const std::string& text) {
  const std::size_t below = text.rfind("\nRuntimeError: ");
  const std::size_t begin = below == text.npos ? 0 : below + 1;
  return text.substr(begin, std::min<std::size_t>(text.find('\n', begin) - begin, 200));
}

class ScriptController : public Controller {
 public:
  explicit ScriptController(torch::jit::Module module) : module_(std::move(module)) {
    module_.eval();
    if (module_.find_method("reset")) module_.get_method("reset")({});
    takes_motion_ = !takes(kObservation.size()) && takes(kAll);
  }

  HandTwist command(const Observation& observation) noexcept override {
    HandTwist v = HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
    if (!failure_.empty()) return v;
    try {
      const torch::NoGradGuard guard;
      const torch::jit::IValue answer = forward(observation);
      const Tensor t = (answer.isTuple() ? answer.toTuple()->elements().at(0) : answer)
                           .toTensor()
                           .to(torch::kFloat64)
                           .contiguous();
      if (t.numel() != v.size() && t.numel() != 3) {
        failure_ = "the network answered " + std::to_string(t.numel()) + " numbers, not 5";
        return v;
      }
      v.setZero();
      std::copy(t.data_ptr<double>(), t.data_ptr<double>() + t.numel(), v.data());
    } catch (const std::exception& error) {
      failure_ = "the network failed: " + reason(error.what());
    }
    return v;
  }
  std::string failure() const override { return failure_; }

 private:
  static constexpr std::size_t kAll = kObservation.size() + kMotion.size();

  // Tried on a copy, which then remembers it.
  bool takes(std::size_t numbers) const {
    try {
      const torch::NoGradGuard guard;
      module_.clone().forward({torch::zeros({1, static_cast<std::int64_t>(numbers)})});
      return true;
    } catch (const std::exception&) {
      return false;
    }
  }

  torch::jit::IValue forward(const Observation& observation) {
    const std::size_t size = takes_motion_ ? kAll : kObservation.size();
    Tensor x = torch::empty({1, static_cast<std::int64_t>(size)});
    for (std::size_t i = 0; i < size; ++i) {
      const bool motion = i >= kObservation.size();
      const ObservationChannel& c = motion ? kMotion[i - kObservation.size()] : kObservation[i];
      x.data_ptr<float>()[i] = static_cast<float>(c.value(observation));
    }
    return module_.forward({x});
  }

  torch::jit::Module module_;
  bool takes_motion_ = false;
  std::string failure_;
};

std::unique_ptr<Controller> script_controller(const std::string& bytes) {
  try {
    torch::set_num_threads(1);
    std::istringstream stream(bytes);
    return std::make_unique<ScriptController>(torch::jit::load(stream));
  } catch (const std::exception& error) {
    throw FileTrouble("cannot be run as TorchScript: " + reason(error.what()));
  }
}

}  // namespace
}  // namespace ferrule

extern "C" {
extern const ferrule::TorchFunctions ferrule_torch_functions;
const ferrule::TorchFunctions ferrule_torch_functions = {ferrule::train, ferrule::train_with_memory,
                                                         ferrule::script, ferrule::run,
                                                         ferrule::script_controller};
}
