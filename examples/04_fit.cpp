// usage: 04_fit FOLDER FILE.json
// Fit a law to the demonstrations in a folder (03_record makes some) and write the controller.
#include <cstdio>

#include "learn/fit_law.hpp"

int main(int argc, char** argv) {
  using namespace ferrule;
  const std::string folder = argc > 1 ? argv[1] : "episodes";
  const std::string file = argc > 2 ? argv[2] : "controller.json";
  const DemonstrationSet demonstrations = load_demonstrations(folder);
  std::printf("%zu successful demonstrations, %zu others\n", demonstrations.demonstrations.size(),
              demonstrations.unsuccessful);

  const std::uint64_t seed = 1;  // draws what is held out
  const LawFit fit = fit_law(demonstrations, seed);
  const LawFile& controller = fit.controller;
  for (std::size_t i = 0; i < controller.gains.size(); ++i) {
    const Gain& gain = gain_of(controller.kind, i);
    const auto& [value, low, high] = controller.gains[i];
    std::printf("%-14s %12.4g  (95 %% %.4g to %.4g) %s\n", gain.name, value, low, high, gain.unit);
  }
  std::printf("velocity error %.3g mm/s, on demonstrations held out %.3g mm/s\n",
              1e3 * controller.residual, 1e3 * controller.held_out_residual);

  write_controller(file, controller);
  // It explains how the operator moved, and the file gives the same law again.
  const LawFile again = read_law(file);
  for (std::size_t i = 0; i < controller.gains.size(); ++i)
    if (again.gains[i].value != controller.gains[i].value) return 1;
  return fit.explained > 0.5 ? 0 : 1;
}
