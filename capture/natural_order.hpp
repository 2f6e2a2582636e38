// The order of names with numbers in them: episode_9999 before episode_10000.
#pragma once

#include <string>

namespace ferrule {

// Digits count by their value, all else by its bytes; of equals the shorter one, which has fewer
// zeros in front, comes first.
bool natural_less(const std::string& a, const std::string& b) noexcept;

}  // namespace ferrule
