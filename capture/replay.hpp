// Playing an episode again: the simulator driven by the recorded hand.
#pragma once

#include <optional>
#include <string>

#include "capture/episode.hpp"

namespace ferrule {

// Drives the simulator through the recorded hand poses and compares every number of every row bit
// for bit, then the outcome. Empty if all are the same. Throws BadInput if the scene is not valid.
std::optional<Difference> verify(const Episode& episode);

}  // namespace ferrule
