// The period of the loop between hand and fibre (insertion/loop.hpp), of trials and of recordings:
// the 1 kHz at which haptic devices render.
#pragma once

namespace ferrule {

inline constexpr double kControlPeriod = 1e-3;  // T [s]

}  // namespace ferrule
