// The losses of networks over the epochs of their training.
#pragma once

#include "app/plot.hpp"
#include "learn/torch_policy.hpp"

namespace ferrule {

Plot training_plot(const std::vector<std::vector<Epoch>>& curves);

}  // namespace ferrule
