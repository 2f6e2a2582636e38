// What connectors lose that are mated at random: the loss of a joint between any two of them, and
// the grade that follows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "controller/statistics.hpp"
#include "sim/scene/joint.hpp"

namespace ferrule {

struct MatedPairs {
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  std::size_t pairs;       // 0 where there are fewer than two connectors
  double mean_dB, p97_dB;  // mean, and what 97 % do not exceed; NaN without pairs
  // 95 % intervals of both, for the lot that the connectors are a random sample of. The high end of
  // the second is infinite where they are too few to bound it; all NaN below kFewestGraded.
  Interval mean_95{kNone, kNone}, p97_95{kNone, kNone};
};

// Fewer connectors have no intervals.
inline constexpr std::size_t kFewestGraded = 20;

// `pairs` times two different connectors out of `ends` face each other, each with its key in a
// direction that is drawn uniformly (pair_loss_dB of sim/scene/joint.hpp). The pairs are the same
// for the same `seed`. `tuned`: each connector is first turned to that of four positions, a right
// angle apart, in which its light leaves nearest to its key, as tunable connectors are: within 45
// degrees of it.
//
// The variance of a mean over pairs, in which a connector comes more than once, is the sum of the
// products of the errors of any two pairs that share one, over the square of their number (Fafchamps
// and Gubert 2007); times n/(n - 1) for n connectors, with Student's t. The interval of the 97 %
// quantile goes between the quantiles that this makes of 97 % (Woodruff 1952).
MatedPairs mate(const Joint& joint, const std::vector<LightAxis>& ends, std::uint64_t seed,
                bool tuned, std::size_t pairs = 10'000);

// What holds at all of several wavelengths: the largest of each number. `all` is not empty.
MatedPairs worst_of(const std::vector<MatedPairs>& all);

// Attenuation grade of random mating, IEC 61755-1:
//   B: mean <= 0.12 dB, 97 % within 0.25 dB;  C: 0.25 and 0.50 dB;  D: 0.50 and 1.0 dB.
// Null where it is worse, and without pairs. Grade A has no limits yet; such pairs are B.
const char* connector_grade(const MatedPairs& pairs) noexcept;

// The grades that the intervals allow, the best first; null: none. Without intervals all of them,
// and without pairs not one.
std::vector<const char*> allowed_grades(const MatedPairs& pairs);

}  // namespace ferrule
