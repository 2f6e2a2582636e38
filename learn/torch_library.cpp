#include <dlfcn.h>

#include <filesystem>

#include "learn/torch_policy.hpp"
#include "sim/error.hpp"

namespace ferrule {
namespace {

#ifdef FERRULE_TORCH
namespace fs = std::filesystem;

// Beside an installed program, or where it was built.
std::string library_file() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path().parent_path() / FERRULE_TORCH_INSTALLED;
  return fs::exists(installed, error) ? installed.string() : FERRULE_TORCH;
}

const TorchFunctions& torch() {
  static const TorchFunctions* functions = nullptr;
  if (functions) return *functions;
  void* library = ::dlopen(library_file().c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library)
    functions = static_cast<const TorchFunctions*>(::dlsym(library, "ferrule_torch_functions"));
  if (!functions) throw FileTrouble(std::string("libtorch cannot be loaded: ") + ::dlerror());
  return *functions;
}
#else
const TorchFunctions& torch() {
  throw BadInput(
      "this program was built without libtorch, which trains networks and writes TorchScript: "
      "install the package libtorch-dev, configure with CMake again and build");
}
#endif

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
