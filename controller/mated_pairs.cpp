#include "controller/mated_pairs.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "controller/statistics.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

// One of 0 to count - 1.
std::size_t one_of_count(RandomStream& random, std::size_t count) {
  return random.bits() % count;
}

// Its light leaves within 45 degrees of the key, which lies along y.
LightAxis tuned_to_key(LightAxis axis) {
  for (int quarter = 0; quarter < 3 && !(axis.offset.x() >= std::abs(axis.offset.y())); ++quarter)
    axis = {{-axis.offset.y(), axis.offset.x()}, {-axis.slope.y(), axis.slope.x()}};
  return axis;
}

}  // namespace

MatedPairs mate(const Joint& joint, const std::vector<LightAxis>& ends, std::uint64_t seed,
                bool tuned, std::size_t pairs) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  if (ends.size() < 2 || pairs == 0) return {0, kNone, kNone};
  std::vector<double> losses(pairs);
  double sum = 0;
  for (std::size_t k = 0; k < pairs; ++k) {
    RandomStream random(seed, k, Draw::mating);
    const std::size_t one = one_of_count(random, ends.size());
    std::size_t other = one_of_count(random, ends.size() - 1);
    other += other >= one;
    const auto keyed = [&](std::size_t which) {
      const LightAxis axis = turned(ends[which], 2 * std::numbers::pi * random.uniform());
      return tuned ? tuned_to_key(axis) : axis;
    };
    const LightAxis from = keyed(one), into = keyed(other);
    losses[k] = pair_loss_dB(joint, from, into);
    sum += losses[k];
  }
  return {pairs, sum / static_cast<double>(pairs), quantile(losses, 0.97)};
}

const char* connector_grade(const MatedPairs& pairs) noexcept {
  const auto within = [&](double mean, double p97) {
    return pairs.mean_dB <= mean && pairs.p97_dB <= p97;
  };
  if (within(0.12, 0.25)) return "B";
  if (within(0.25, 0.50)) return "C";
  if (within(0.50, 1.0)) return "D";
  return nullptr;
}

}  // namespace ferrule
