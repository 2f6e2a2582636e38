#include "capture/simulated_operator.hpp"

#include "capture/episode.hpp"
#include "sim/random.hpp"

namespace ferrule {

std::unique_ptr<Device> simulated_operator(const Scene& scene, const State& start, double skill,
                                           double period, std::uint64_t seed,
                                           std::uint64_t trial) {
  const Scaling scaling = scene_scaling(scene);
  const double distance = scene.start.distance + 1.1 * scene.success.depth;
  const TraineeTask task = {scaling.motion_to_hand(start.hand), scaling.motion * distance,
                            scaling.motion * scene.limits.speed, period};
  return std::make_unique<Trainee>(
      trainee_traits(skill), task,
      [random = RandomStream(seed, trial, Draw::operator_hand)]() mutable {
        return random.uniform();
      });
}

}  // namespace ferrule
