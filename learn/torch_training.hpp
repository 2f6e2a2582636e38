// train_network and train_memory (learn/torch_policy.hpp), as the library that is loaded has them.
#pragma once

#include "learn/torch_policy.hpp"

namespace ferrule::by_libtorch {

TrainedNetwork train_network(const TrainingRows& training, const TrainingRows& held_out,
                             const TrainingSettings& settings, std::uint64_t seed,
                             const TrainingProgress& progress);
TrainedNetwork train_memory(const std::vector<TrainingRows>& training,
                            const std::vector<TrainingRows>& held_out,
                            const TrainingSettings& settings, std::uint64_t seed,
                            const TrainingProgress& progress);

}  // namespace ferrule::by_libtorch
