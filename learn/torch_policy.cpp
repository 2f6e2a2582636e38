#include "learn/torch_policy.hpp"

#include <torch/script.h>
#include <torch/torch.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "learn/tensors.hpp"
#include "learn/torch_training.hpp"
#include "sim/base/error.hpp"

namespace ferrule {
namespace {

using torch::Tensor;

Tensor constant(const Eigen::VectorXd& values) {
  return torch::from_blob(const_cast<double*>(values.data()), {values.size()}, torch::kFloat64)
      .clone();
}

// A module under construction, and the code of its `forward`.
struct Script {
  torch::jit::Module module{"ferrule_policy"};
  std::ostringstream code;

  // The code for W in + b.
  std::string linear(const std::string& at, const Eigen::MatrixXf& weight,
                     const Eigen::VectorXf& bias, const std::string& in) {
    // Eigen's columns are the rows of the transpose.
    module.register_parameter("weight_" + at, to_tensor(weight).t().contiguous(), false);
    module.register_parameter("bias_" + at, to_tensor(bias).view({-1}), false);
    return "torch.addmm(self.bias_" + at + ", " + in + ", self.weight_" + at + ".t())";
  }

  // h, what member `m` remembers by then.
  void add(const std::string& m, const Gru& gru) {
    code << "    old = memory[" << m << "]\n"
         << "    a_r, a_u, a_n = torch.chunk("
         << linear("input_" + m, gru.input_weight, gru.input_bias, "z") << ", 3, 1)\n"
         << "    c_r, c_u, c_n = torch.chunk("
         << linear("memory_" + m, gru.memory_weight, gru.memory_bias, "old") << ", 3, 1)\n"
         << "    u = torch.sigmoid(a_u + c_u)\n"
         << "    h = (1 - u) * torch.tanh(a_n + torch.sigmoid(a_r + c_r) * c_n) + u * old\n"
         << "    remembered.append(h)\n";
  }

  // The outputs of member `m` from h.
  void add(const std::string& m, const Network& network, int answers) {
    for (std::size_t i = 0; i < network.size(); ++i) {
      const std::string layer =
          linear(m + "_" + std::to_string(i), network[i].weight, network[i].bias, "h");
      code << "    h = " << (i + 1 < network.size() ? "torch.tanh(" + layer + ")" : layer) << "\n";
    }
    code << "    means.append(h[:, :" << answers << "].double())\n"
         << "    variances.append(torch.exp(2 * torch.clamp(h[:, " << answers << ":].double(), "
         << kLowestLogSd << ", " << kHighestLogSd << ")))\n";
  }
};

std::string script(const Policy& policy) {
  const bool remembers = !policy.memories.empty();
  Script script;
  Eigen::VectorXd mean(policy.inputs()), scale(policy.inputs());
  for (int i = 0; i < policy.inputs(); ++i) {
    mean[i] = policy.mean[policy.channel(i)];
    scale[i] = policy.scale[policy.channel(i)];
  }
  script.module.register_buffer("mean", constant(mean));
  script.module.register_buffer("scale", constant(scale));
  script.module.register_buffer("velocity_mean", constant(policy.velocity_mean));
  script.module.register_buffer("velocity_scale", constant(policy.velocity_scale));
  std::ostringstream& code = script.code;
  code.precision(17);
  code << "def forward(self, inputs" << (remembers ? ", memory" : "") << "):\n"
       << "    z = ((inputs - self.mean) / self.scale).float()\n"
       << "    means = []\n"
       << "    variances = []\n"
       << (remembers ? "    remembered = []\n" : "");
  for (std::size_t m = 0; m < policy.members.size(); ++m) {
    code << "    h = z\n";
    if (remembers) script.add(std::to_string(m), policy.memories[m]);
    script.add(std::to_string(m), policy.members[m], policy.answers());
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
  script.module.define(code.str());
  std::ostringstream bytes;
  script.module.save(bytes);
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
    for (const std::size_t numbers : {kObservation.size(), kAll - 1, kAll})
      if (takes(numbers)) {
        numbers_ = numbers;
        break;
      }
  }

  HandTwist command(const Observation& observation) noexcept override {
    HandTwist v = HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
    if (!failure_.empty()) return v;
    try {
      const torch::NoGradGuard guard;
      const torch::jit::IValue answer = forward(observation);
      const auto elements =
          answer.isTuple() ? answer.toTuple()->elements().vec() : std::vector{answer};
      const Tensor t = elements.at(0).toTensor().to(torch::kFloat64).contiguous();
      done_ = elements.size() > 1 && elements[1].isBool() && elements[1].toBool();
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
  bool done() const noexcept override { return done_; }
  std::string failure() const override { return failure_; }

 private:
  static constexpr std::size_t kAll = kObservation.size() + kMotion.size() + 1;

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
    const Tensor all = torch::empty({1, static_cast<std::int64_t>(kAll)});
    float* next = all.data_ptr<float>();
    for (const ObservationChannel& c : kObservation)
      *next++ = static_cast<float>(c.value(observation));
    for (const ObservationChannel& c : kMotion) *next++ = static_cast<float>(c.value(observation));
    *next = static_cast<float>(observation.force_limit);
    return module_.forward({all.narrow(1, 0, static_cast<std::int64_t>(numbers_))});
  }

  torch::jit::Module module_;
  std::size_t numbers_ = kObservation.size();  // of an observation, that it takes in
  bool done_ = false;
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
const ferrule::TorchFunctions ferrule_torch_functions = {
    ferrule::by_libtorch::train_network, ferrule::script, ferrule::run, ferrule::script_controller};
}
