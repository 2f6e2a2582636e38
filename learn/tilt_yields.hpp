// How a hand tilts under the moments that it feels: the tilt gains of a law (controller/law.hpp).
//
//   w_y = C_y M_y,   w_z = C_z M_z
//
// by least squares over the rows in which the hand moves, C >= 0, with the intervals of
// learn/intervals.hpp, and kLeastError (learn/free_course.hpp) to each side. A hand that tilts for
// other reasons, to offer an edge say, is not imitated so.
#pragma once

#include <cmath>
#include <vector>

#include "controller/law_file.hpp"
#include "learn/samples.hpp"

namespace ferrule {

inline constexpr double kLeastToldByMoments = 0.3;  // of the rates' mean square

struct TiltYields {
  // Of the mean square of the rates of tilt, what the moments explain; NaN where no hand tilted.
  double share = NAN;
  std::vector<FittedGain> gains{};  // as kTiltGains; empty below kLeastToldByMoments
};

// At least two episodes.
TiltYields tilt_yields(const std::vector<Samples>& episodes);

}  // namespace ferrule
