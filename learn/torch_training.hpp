// train_network (learn/torch_policy.hpp), as the library that is loaded has it.
#pragma once

#include "learn/torch_policy.hpp"

namespace ferrule::by_libtorch {

decltype(ferrule::train_network) train_network;

}  // namespace ferrule::by_libtorch
