// What connectors lose that are mated at random: the loss of a joint between any two of them, and
// the grade that follows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sim/scene/joint.hpp"

namespace ferrule {

struct MatedPairs {
  std::size_t pairs;       // 0 where there are fewer than two connectors
  double mean_dB, p97_dB;  // mean, and what 97 % do not exceed; NaN without pairs
};

// `pairs` times two different connectors out of `ends` face each other, each with its key in a
// direction that is drawn uniformly (pair_loss_dB of sim/scene/joint.hpp). The pairs are the same
// for the same `seed`. `tuned`: each connector is first turned to that of four positions, a right
// angle apart, in which its light leaves nearest to its key, as tunable connectors are: within 45
// degrees of it.
MatedPairs mate(const Joint& joint, const std::vector<LightAxis>& ends, std::uint64_t seed,
                bool tuned, std::size_t pairs = 10'000);

// Attenuation grade of random mating, IEC 61755-1:
//   B: mean <= 0.12 dB, 97 % within 0.25 dB;  C: 0.25 and 0.50 dB;  D: 0.50 and 1.0 dB.
// Null where it is worse, and without pairs. Grade A has no limits yet; such pairs are B.
const char* connector_grade(const MatedPairs& pairs) noexcept;

}  // namespace ferrule
