// train_network and train_memory (learn/torch_policy.hpp), as the library that is loaded has them.
#pragma once

#include "learn/torch_policy.hpp"

namespace ferrule::by_libtorch {

decltype(ferrule::train_network) train_network;
decltype(ferrule::train_memory) train_memory;

}  // namespace ferrule::by_libtorch
