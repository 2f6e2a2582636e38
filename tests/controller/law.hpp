// A law that inserts, for tests.
#pragma once

#include "controller/law.hpp"

namespace ferrule {

inline const Law kLaw(LawKind::insertion,
                      {2.5e-3, 0.5, 0.012, 0.004, 0.2, 0, 0.9e-3, 0.9e-3, 0, 0, 0, 0});

}  // namespace ferrule
