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

struct Perceptron {
  std::vector<Tensor> weights, biases;

  Perceptron(std::int64_t inputs, const std::vector<int>& hidden) {
    std::vector<std::int64_t> widths = {inputs};
    widths.insert(widths.end(), hidden.begin(), hidden.end());
    widths.push_back(2 * kVelocity);
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
    using RowMajor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Network n;
    for (std::size_t i = 0; i < weights.size(); ++i) {
      const Tensor w = weights[i].detach().contiguous(), b = biases[i].detach().contiguous();
      n.push_back({Eigen::Map<const RowMajor>(w.data_ptr<float>(), w.size(0), w.size(1)),
                   Eigen::Map<const Eigen::VectorXf>(b.data_ptr<float>(), b.size(0))});
    }
    return n;
  }
};

Tensor negative_log_likelihood(const Tensor& output, const Tensor& velocity) {
  const Tensor mean = output.narrow(1, 0, kVelocity);
  const Tensor log_sd = output.narrow(1, kVelocity, kVelocity).clamp(kLowestLogSd, kHighestLogSd);
  const Tensor error = (velocity - mean) * torch::exp(-log_sd);
  return (0.5 * error * error + log_sd).sum(1).mean();
}

TrainedNetwork train(const TrainingRows& training, const TrainingRows& held_out,
                     const TrainingSettings& settings, std::uint64_t seed,
                     const TrainingProgress& progress) {
  torch::set_num_threads(1);
  torch::manual_seed(seed);
  torch::globalContext().setDeterministicAlgorithms(true, false);
  const Tensor x = to_tensor(training.input), v = to_tensor(training.velocity);
  const Tensor x_held = to_tensor(held_out.input), v_held = to_tensor(held_out.velocity);
  const Perceptron perceptron(x.size(1), settings.hidden);
  torch::optim::AdamW optimiser(
      perceptron.parameters(),
      torch::optim::AdamWOptions(settings.learning_rate).weight_decay(settings.weight_decay));

  TrainedNetwork result;
  double least = std::numeric_limits<double>::infinity();
  for (int epoch = 0; epoch < settings.epochs; ++epoch) {
    const double along = static_cast<double>(epoch) / settings.epochs;
    static_cast<torch::optim::AdamWOptions&>(optimiser.param_groups()[0].options())
        .lr(settings.learning_rate * 0.5 * (1 + std::cos(std::numbers::pi * along)));
    const Tensor order = torch::randperm(x.size(0));
    double loss_sum = 0;
    for (std::int64_t begin = 0; begin < x.size(0); begin += settings.batch) {
      const Tensor rows =
          order.narrow(0, begin, std::min<std::int64_t>(settings.batch, x.size(0) - begin));
      Tensor input = x.index_select(0, rows);
      input = input + settings.input_noise * torch::randn_like(input);
      const Tensor loss =
          negative_log_likelihood(perceptron.forward(input), v.index_select(0, rows));
      optimiser.zero_grad();
      loss.backward();
      optimiser.step();
      loss_sum += loss.item<double>() * static_cast<double>(rows.size(0));
    }
    const torch::NoGradGuard guard;
    const Epoch now = {loss_sum / static_cast<double>(x.size(0)),
                       negative_log_likelihood(perceptron.forward(x_held), v_held).item<double>()};
    result.curve.push_back(now);
    const bool go_on = !progress || progress(result.curve.size(), now);
    if (now.held_out_loss < least) {
      least = now.held_out_loss;
      result.best = result.curve.size() - 1;
      result.network = perceptron.network();
    }
    if (!go_on || result.curve.size() - result.best > static_cast<std::size_t>(settings.patience))
      break;
  }
  return result;
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
  std::ostringstream code;
  code.precision(17);
  code << "def forward(self, inputs):\n"
       << "    z = ((inputs - self.mean) / self.scale).float()\n"
       << "    means = []\n"
       << "    variances = []\n";
  for (std::size_t m = 0; m < policy.members.size(); ++m) {
    const Network& network = policy.members[m];
    code << "    h = z\n";
    for (std::size_t i = 0; i < network.size(); ++i) {
      const std::string at = std::to_string(m) + "_" + std::to_string(i);
      // Eigen's columns are the rows of the transpose.
      module.register_parameter("weight_" + at, to_tensor(network[i].weight).t().contiguous(),
                                false);
      module.register_parameter("bias_" + at, to_tensor(network[i].bias).view({-1}), false);
      const std::string linear = "torch.addmm(self.bias_" + at + ", h, self.weight_" + at + ".t())";
      code << "    h = " << (i + 1 < network.size() ? "torch.tanh(" + linear + ")" : linear)
           << "\n";
    }
    code << "    means.append(h[:, :3].double())\n"
         << "    variances.append(torch.exp(2 * torch.clamp(h[:, 3:].double(), " << kLowestLogSd
         << ", " << kHighestLogSd << ")))\n";
  }
  code << "    stacked = torch.stack(means)\n"
       << "    mean = stacked.mean(0)\n"
       << "    velocity = self.velocity_mean + self.velocity_scale * mean\n"
       << "    speed = (velocity * velocity).sum([1], True).sqrt()\n"
       << "    limit = " << policy.speed_limit << "\n"
       << "    velocity = velocity * torch.where(speed > limit, limit / speed, "
          "torch.ones_like(speed))\n"
       << "    deviation = self.velocity_scale * torch.stack(variances).mean(0).sqrt()\n"
       << "    among = ((stacked - mean) ** 2).mean(0).sqrt()\n"
       << "    return velocity, deviation, self.velocity_scale * among\n";
  module.define(code.str());
  std::ostringstream bytes;
  module.save(bytes);
  return bytes.str();
}

Eigen::MatrixXd run(const std::string& bytes, const Eigen::MatrixXd& inputs) {
  torch::set_num_threads(1);
  const torch::NoGradGuard guard;
  std::istringstream stream(bytes);
  torch::jit::Module module = torch::jit::load(stream);
  const Tensor x = torch::from_blob(const_cast<double*>(inputs.data()),
                                    {inputs.cols(), inputs.rows()}, torch::kFloat64);
  const auto answer = module.forward({x}).toTuple();
  Eigen::MatrixXd all(3 * kVelocity, inputs.cols());
  for (int part = 0; part < 3; ++part) {
    const Tensor t = answer->elements()[static_cast<std::size_t>(part)].toTensor().contiguous();
    all.middleRows(part * kVelocity, kVelocity) =
        Eigen::Map<const Eigen::MatrixXd>(t.data_ptr<double>(), kVelocity, inputs.cols());
  }
  return all;
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
  }

  HandTwist command(const Observation& observation) noexcept override {
    HandTwist v = HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
    if (!failure_.empty()) return v;
    try {
      const torch::NoGradGuard guard;
      Tensor x = torch::empty({1, static_cast<std::int64_t>(kObservation.size())});
      for (std::size_t i = 0; i < kObservation.size(); ++i)
        x.data_ptr<float>()[i] = static_cast<float>(kObservation[i].value(observation));
      const torch::jit::IValue answer = module_.forward({x});
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
  torch::jit::Module module_;
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
const ferrule::TorchFunctions ferrule_torch_functions = {ferrule::train, ferrule::script,
                                                         ferrule::run, ferrule::script_controller};
}
