#include <filesystem>

#include "learn/loaded_library.hpp"
#include "learn/torch_policy.hpp"
#include "sim/base/json_fields.hpp"

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

TrainedNetwork train_network(const std::vector<TrainingRows>& training,
                             const std::vector<TrainingRows>& held_out,
                             const TrainingSettings& settings, std::uint64_t seed,
                             const TrainingProgress& progress) {
  return torch().train(training, held_out, settings, seed, progress);
}

std::string torchscript_bytes(const Policy& policy) {
  return torch().script(policy);
}

Eigen::MatrixXd run_torchscript(const std::string& bytes, const Eigen::MatrixXd& inputs,
                                std::array<int, 2> memory) {
  return torch().run(bytes, inputs, memory);
}

std::unique_ptr<Controller> torchscript_controller(const std::string& bytes) {
  return torch().controller(bytes);
}

MakeController load_torchscript(const std::string& file, const ProgramSettings& settings) {
  constexpr std::size_t kMost = 512 << 20, kMemory = 1 << 30;
  std::error_code error;
  const std::size_t size = std::filesystem::file_size(file, error);
  if (error) throw FileTrouble(file + ": cannot be read: " + error.message());
  if (size > kMost) throw FileTrouble(file + ": is larger than 512 MB");
  torch();  // here, and all processes share it
  MakeController make = forked_policy(
      [file, bytes = std::string()](std::uint64_t) mutable {
        if (bytes.empty()) bytes = read_text(file);
        return torchscript_controller(bytes);
      },
      kMemory + 4 * size, settings);
  const auto tried = make(0);  // refused before any trial
  tried->command({HandWrench::Zero(), 0, 0});
  if (!tried->failure().empty()) throw FileTrouble(file + ": " + printable(tried->failure(), 300));
  return make;
}

}  // namespace ferrule
