// Factors between the units of a scene file and SI.
#pragma once

#include <numbers>

namespace ferrule {

inline constexpr double nano = 1e-9, micro = 1e-6, milli = 1e-3, giga = 1e9;
inline constexpr double degree = std::numbers::pi / 180;  // [rad]

}  // namespace ferrule
