#include "learn/loaded_library.hpp"
#include "learn/torch_policy.hpp"

namespace ferrule {
namespace {

const TorchFunctions& torch() {
  static const auto* const functions = static_cast<const TorchFunctions*>(
      loaded_symbol("ferrule_torch.so", "ferrule_torch_functions", "libtorch-dev"));
  return *functions;
}

}  // namespace

TrainedNetwork train_network(const TrainingRows& training, const TrainingRows& held_out,
                             const TrainingSettings& settings, std::uint64_t seed,
                             const TrainingProgress& progress) {
  return torch().train(training, held_out, settings, seed, progress);
}

std::string torchscript_bytes(const Policy& policy) {
  return torch().script(policy);
}

Eigen::MatrixXd run_torchscript(const std::string& bytes, const Eigen::MatrixXd& inputs) {
  return torch().run(bytes, inputs);
}

}  // namespace ferrule
