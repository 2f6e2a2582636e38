// What a haptic loop is run at, for tests.
#pragma once

namespace ferrule {

inline constexpr double T = 1e-3;  // [s]

}  // namespace ferrule
