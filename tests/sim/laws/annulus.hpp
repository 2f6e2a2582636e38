// The gap between fibre and bore in Table I of the paper, for tests.
#pragma once

#include "sim/geometry/annulus.hpp"

namespace ferrule {

inline constexpr Annulus kAnnulus = {62.5e-6, 63e-6};  // [m]

}  // namespace ferrule
