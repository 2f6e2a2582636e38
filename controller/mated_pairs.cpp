#include "controller/mated_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sim/base/random.hpp"

namespace ferrule {
namespace {

constexpr double kShare = 0.97;

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

struct PairLoss {
  std::size_t one, other;
  double loss_dB;
};

// Half of the 95 % interval of the mean over the pairs of what has these errors against it.
template <class Error>
double half_interval(const std::vector<PairLoss>& pairs, std::size_t connectors,
                     const Error& error) {
  std::vector<double> sums(connectors);
  double sum = 0;  // of the products; a pair shares both with itself
  for (const PairLoss& pair : pairs) {
    const double e = error(pair);
    sums[pair.one] += e;
    sums[pair.other] += e;
    sum -= e * e;
  }
  for (const double each : sums) sum += each * each;
  const double n = static_cast<double>(connectors), count = static_cast<double>(pairs.size());
  const double z = two_sided_z();
  const double t = z + (z * z * z + z) / (4 * (n - 1));  // Student's, to 1 % from n = 10 on
  return t * std::sqrt(std::max(0.0, sum) * n / (n - 1)) / count;
}

void add_intervals(const std::vector<PairLoss>& pairs, const std::vector<double>& losses,
                   std::size_t connectors, MatedPairs& mated) {
  const double of_mean = half_interval(
      pairs, connectors, [&](const PairLoss& p) { return p.loss_dB - mated.mean_dB; });
  mated.mean_95 = {std::max(0.0, mated.mean_dB - of_mean), mated.mean_dB + of_mean};
  const double of_share = half_interval(
      pairs, connectors, [&](const PairLoss& p) { return (p.loss_dB <= mated.p97_dB) - kShare; });
  const double high = kShare + of_share;
  mated.p97_95 = {quantile(losses, std::max(0.0, kShare - of_share)),
                  high < 1 ? quantile(losses, high) : std::numeric_limits<double>::infinity()};
}

}  // namespace

MatedPairs mate(const Joint& joint, const std::vector<LightAxis>& ends, std::uint64_t seed,
                bool tuned, std::size_t pairs) {
  constexpr double kNone = MatedPairs::kNone;
  if (ends.size() < 2 || pairs == 0) return {0, kNone, kNone};
  std::vector<PairLoss> all(pairs);
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
    all[k] = {one, other, losses[k]};
    sum += losses[k];
  }
  MatedPairs mated{pairs, sum / static_cast<double>(pairs), quantile(losses, kShare)};
  if (ends.size() >= kFewestGraded) add_intervals(all, losses, ends.size(), mated);
  return mated;
}

MatedPairs worst_of(const std::vector<MatedPairs>& all) {
  MatedPairs worst = all.front();
  for (const MatedPairs& each : all) {
    worst.mean_dB = std::max(worst.mean_dB, each.mean_dB);
    worst.p97_dB = std::max(worst.p97_dB, each.p97_dB);
    for (const auto& interval : {&MatedPairs::mean_95, &MatedPairs::p97_95}) {
      (worst.*interval).low = std::max((worst.*interval).low, (each.*interval).low);
      (worst.*interval).high = std::max((worst.*interval).high, (each.*interval).high);
    }
  }
  return worst;
}

namespace {

constexpr std::array<const char*, 4> kGrades = {"B", "C", "D", nullptr};

// The place of the grade in kGrades.
std::size_t grade_of(double mean_dB, double p97_dB) {
  const auto within = [&](double mean, double p97) { return mean_dB <= mean && p97_dB <= p97; };
  return within(0.12, 0.25) ? 0 : within(0.25, 0.50) ? 1 : within(0.50, 1.0) ? 2 : 3;
}

}  // namespace

const char* connector_grade(const MatedPairs& pairs) noexcept {
  return kGrades[grade_of(pairs.mean_dB, pairs.p97_dB)];
}

std::vector<const char*> allowed_grades(const MatedPairs& pairs) {
  if (pairs.pairs == 0) return {};
  if (std::isnan(pairs.mean_95.low)) return {kGrades.begin(), kGrades.end()};
  const auto best = static_cast<std::ptrdiff_t>(grade_of(pairs.mean_95.low, pairs.p97_95.low));
  const auto worst = static_cast<std::ptrdiff_t>(grade_of(pairs.mean_95.high, pairs.p97_95.high));
  return {kGrades.begin() + best, kGrades.begin() + worst + 1};
}

}  // namespace ferrule
