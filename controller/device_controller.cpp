#include "controller/device_controller.hpp"

#include "insertion/simulated_operator.hpp"

namespace ferrule {

MakeController simulated_operators(const Scene& scene, const OperatorSkill& skill,
                                   std::uint64_t seed) {
  return [&scene, skill, seed](std::uint64_t trial) -> std::unique_ptr<Controller> {
    const auto setup = trial_setup(scene, seed, trial);
    if (!setup) return std::make_unique<ConstantVelocity>(0);
    return std::make_unique<DeviceController>(simulated_operator(*setup, skill), kControlPeriod);
  };
}

}  // namespace ferrule
