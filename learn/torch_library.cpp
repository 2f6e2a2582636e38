#include "learn/loaded_library.hpp"
#include "learn/torch_policy.hpp"
#include "sim/scene/json_fields.hpp"

namespace ferrule {
namespace {

const TorchFunctions& torch() {
  static const auto* const functions = static_cast<const TorchFunctions*>(
      loaded_symbol("ferrule_torch.so", "ferrule_torch_functions",
                    "libtorch, which trains networks: train them in a clone on Debian, where "
                    "./ferrule installs libtorch-dev; trained networks run everywhere"));
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

std::unique_ptr<Controller> torchscript_controller(const std::string& bytes) {
  return torch().controller(bytes);
}

MakeController load_torchscript(const std::string& file) {
  const std::string bytes = read_text(file);
  try {  // refused before any trial
    const auto tried = torchscript_controller(bytes);
    tried->command({HandWrench::Zero(), 0, 0});
    if (!tried->failure().empty()) throw FileTrouble(tried->failure());
  } catch (const FileTrouble& error) {
    throw FileTrouble(file + ": " + printable(error.what(), 300));
  }
  return [bytes](std::uint64_t) { return torchscript_controller(bytes); };
}

}  // namespace ferrule
