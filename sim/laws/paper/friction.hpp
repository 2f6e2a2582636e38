// Friction as printed: (8) to (10) of the paper (sim/laws/friction.hpp) at the contact radius that
// its adhesion prescribes (sim/laws/paper/adhesion.hpp).
#pragma once

#include "sim/laws/friction.hpp"
#include "sim/laws/paper/adhesion.hpp"

namespace ferrule::printed {

struct Friction : ferrule::Friction {};

}  // namespace ferrule::printed
