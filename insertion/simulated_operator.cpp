#include "insertion/simulated_operator.hpp"

#include <algorithm>

#include "insertion/scene_scaling.hpp"
#include "sim/scene/random.hpp"

namespace ferrule {
namespace {

constexpr double kPress = 0.6;  // 0.7 uN at the tip with the paper's scaling [N]

}  // namespace

TraineeTask trainee_task(const Scene& scene, const State& start, double period) noexcept {
  const Scaling scaling = scene_scaling(scene);
  const double distance = scene.start.distance + scene.success.depth + overshoot(scene);
  return {scaling.motion_to_hand(start.command), scaling.motion * distance,
          scaling.motion * scene.limits.speed, kPress, period};
}

std::unique_ptr<Device> simulated_operator(const Scene& scene, const State& start, double skill,
                                           double period, std::uint64_t seed, std::uint64_t trial) {
  return std::make_unique<Trainee>(
      trainee_traits(skill), trainee_task(scene, start, period),
      [random = RandomStream(seed, trial, Draw::operator_hand)]() mutable {
        return random.uniform();
      });
}

}  // namespace ferrule
