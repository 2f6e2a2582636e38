#include "capture/force_history.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr double kNever = std::numeric_limits<double>::quiet_NaN();

double middle(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), at, values.end());
  return values.size() % 2 ? *at : 0.5 * (*at + *std::max_element(values.begin(), at));
}

Vector3d force_of(const RowVector& row, Term term) {
  return row.segment<3>(force_column(term)).transpose();
}

// What is summed up of a term, row by row.
struct Sums {
  std::vector<double> magnitudes;
  std::array<std::size_t, 2> acts{};  // apart, touching
  double first = kNever, last = kNever;
  double sum = 0, reaching = 0;
  std::size_t noticed = 0;
};

// f_k of each term.
std::array<double, kTerms> reaching(const RowVector& row, const RowVector& rest,
                                    const Vector3d& felt) {
  std::array<double, kTerms> parts{};
  const double size = felt.norm();
  if (!(size > 0)) return parts;
  double pushing = 0;
  for (const Term term : kAllTerms) {
    double& part = parts[static_cast<std::size_t>(term)];
    part = std::max(0.0, (force_of(row, term) - force_of(rest, term)).dot(felt) / size);
    pushing += part;
  }
  if (pushing > size)
    for (double& part : parts) part *= size / pushing;
  return parts;
}

TermActivity activity(Term term, const Sums& s, const std::array<std::size_t, 2>& rows,
                      double felt) {
  const auto share = [](std::size_t part, std::size_t all) {
    return all ? static_cast<double>(part) / static_cast<double>(all) : kNever;
  };
  const std::size_t all = rows[0] + rows[1];
  return {.term = term,
          .acts = share(s.acts[0] + s.acts[1], all),
          .apart = share(s.acts[0], rows[0]),
          .touching = share(s.acts[1], rows[1]),
          .first = s.first,
          .last = s.last,
          .median = middle(s.magnitudes),
          .largest = s.magnitudes.empty()
                         ? 0
                         : *std::max_element(s.magnitudes.begin(), s.magnitudes.end()),
          .reaches = s.sum > 0 ? s.reaching / s.sum : kNever,
          .of_felt = felt > 0 ? s.reaching / felt : kNever,
          .noticed = share(s.noticed, all)};
}

}  // namespace

bool touches(const RowVector& row) noexcept {
  return row[kStates.begin + 13] != 0 || row[kStates.begin + 19] != 0;
}

ForceHistory force_history(const Episode& episode, const Scene& scene) {
  const double to_hand = scene_scaling(scene).force;
  const RowVector rest = episode.rows.row(0);
  std::array<Sums, kTerms> sums;
  std::array<std::size_t, 2> rows{};  // apart, touching
  std::vector<double> felt;
  double felt_sum = 0;
  for (Eigen::Index n = 0; n < episode.rows.rows(); ++n) {
    const RowVector row = episode.rows.row(n);
    const std::size_t contact = touches(row);
    ++rows[contact];
    const Vector3d now = (block(row, kHolder) - block(rest, kHolder)).head<3>().transpose();
    felt.push_back(now.norm());
    felt_sum += felt.back();
    const std::array<double, kTerms> parts = reaching(row, rest, now);
    const double noticed = std::max(kNoticedForce / to_hand, kNoticedShare * felt.back());
    for (const Term term : kAllTerms) {
      Sums& s = sums[static_cast<std::size_t>(term)];
      const double magnitude = force_of(row, term).norm();
      const double part = parts[static_cast<std::size_t>(term)];
      s.reaching += part;
      s.noticed += part >= noticed;
      if (magnitude == 0) continue;
      s.sum += magnitude;
      s.magnitudes.push_back(magnitude);
      ++s.acts[contact];
      s.last = row[kTime.begin];
      if (std::isnan(s.first)) s.first = s.last;
    }
  }
  ForceHistory history{static_cast<double>(rows[1]) / static_cast<double>(rows[0] + rows[1]),
                       middle(felt),
                       *std::max_element(felt.begin(), felt.end()),
                       {}};
  for (const Term term : kAllTerms)
    if (info(term).present(scene.world.laws))
      history.terms.push_back(activity(term, sums[static_cast<std::size_t>(term)], rows, felt_sum));
  return history;
}

}  // namespace ferrule
