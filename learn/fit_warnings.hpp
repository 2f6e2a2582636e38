// What somebody who fits a controller must be warned of.
#pragma once

#include "learn/learner.hpp"

namespace ferrule {

// One line each:
//   - a gain that answers a force sideways, where the forces hardly explain the velocity: of what it
//     varies at the same height, less than 3 tenths, over the rows that were fitted
//     (learn/free_course.hpp). The hand's own motion then makes most of the force that is felt, and
//     a regression of one on the other is biased, however tight its interval.
//   - a yield that is another one outside the bore than inside, or under forces below the median
//     than above: with 95 % intervals (with any course, as above) that are more than a tenth of it
//     apart. What one number says of it is a mixture then, and its interval holds neither.
//   - a law that does not tilt though the hands did, for other reasons than the moments
//     (learn/tilt_yields.hpp).
//   - files that were left out as copies of others.
//   - a controller that meets no force at all, and yet does not reach the success depth within the
//     longest trial of a scene that it learned from.
std::vector<std::string> fit_warnings(const DemonstrationSet& set,
                                      const ControllerFile& controller);

// Time in which a controller that feels nothing reaches the success depth of `scene` [s]; infinity
// where it does not within the longest trial.
double time_without_force(const MakeController& make, const Scene& scene);

}  // namespace ferrule
