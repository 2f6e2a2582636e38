#include "capture/force_history.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "insertion/scene_scaling.hpp"
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

double share_of(std::size_t part, std::size_t all) {
  return all ? static_cast<double>(part) / static_cast<double>(all) : kNever;
}

double largest(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

void extend(std::vector<double>& to, const std::vector<double>& more) {
  to.insert(to.end(), more.begin(), more.end());
}

}  // namespace

bool touches(const RowVector& row) noexcept {
  return row[state_column("end_closed")] != 0 || row[state_column("side_closed")] != 0;
}

InsertionForces::InsertionForces(const Scene& scene) : to_hand_(scene_scaling(scene).force) {
  for (const Term term : kAllTerms)
    present_[static_cast<std::size_t>(term)] = info(term).present(scene.world.laws);
}

InsertionForces::InsertionForces(const Episode& episode, const Scene& scene)
    : InsertionForces(scene) {
  for (Eigen::Index n = 0; n < episode.rows.rows(); ++n) add(episode.rows.row(n));
}

void InsertionForces::add(const RowVector& row) {
  if (!rest_) rest_ = row;
  insertions_ = 1;
  const std::size_t contact = touches(row);
  ++rows_[contact];
  const Vector3d now = (block(row, kHolder) - block(*rest_, kHolder)).head<3>().transpose();
  felt_.push_back(now.norm());
  const std::array<double, kTerms> parts = reaching(row, *rest_, now);
  const double noticed = std::max(kNoticedForce / to_hand_, kNoticedShare * felt_.back());
  for (const Term term : kAllTerms) {
    Sums& s = terms_[static_cast<std::size_t>(term)];
    const double magnitude = force_of(row, term).norm();
    const double part = parts[static_cast<std::size_t>(term)];
    s.reaching += part;
    s.noticed += part >= noticed;
    if (magnitude == 0) continue;
    s.sum += magnitude;
    s.magnitudes.push_back(magnitude);
    ++s.acts[contact];
    s.last.assign(1, row[kTime.begin]);
    if (s.first.empty()) s.first = s.last;
  }
}

void InsertionForces::append(const InsertionForces& other) {
  insertions_ += other.insertions_;
  extend(felt_, other.felt_);
  for (std::size_t contact = 0; contact < 2; ++contact) rows_[contact] += other.rows_[contact];
  for (std::size_t i = 0; i < kTerms; ++i) {
    Sums& s = terms_[i];
    const Sums& more = other.terms_[i];
    extend(s.magnitudes, more.magnitudes);
    extend(s.first, more.first);
    extend(s.last, more.last);
    for (std::size_t contact = 0; contact < 2; ++contact) s.acts[contact] += more.acts[contact];
    s.sum += more.sum;
    s.reaching += more.reaching;
    s.noticed += more.noticed;
    present_[i] = present_[i] || other.present_[i];
  }
}

TermActivity InsertionForces::activity(Term term) const {
  const Sums& s = terms_[static_cast<std::size_t>(term)];
  const std::size_t all = rows_[0] + rows_[1];
  const double felt = std::accumulate(felt_.begin(), felt_.end(), 0.0);
  return {.term = term,
          .acts = share_of(s.acts[0] + s.acts[1], all),
          .apart = share_of(s.acts[0], rows_[0]),
          .touching = share_of(s.acts[1], rows_[1]),
          .first = s.first.empty() ? kNever : middle(s.first),
          .last = s.last.empty() ? kNever : middle(s.last),
          .median = middle(s.magnitudes),
          .largest = largest(s.magnitudes),
          .reaches = s.sum > 0 ? s.reaching / s.sum : kNever,
          .of_felt = felt > 0 ? s.reaching / felt : kNever,
          .noticed = share_of(s.noticed, all)};
}

ForceHistory force_history(std::vector<InsertionForces> insertions) {
  InsertionForces all = std::move(insertions.at(0));
  for (std::size_t i = 1; i < insertions.size(); ++i) all.append(insertions[i]);
  const auto& [apart, touching] = all.rows_;
  ForceHistory history{all.insertions_,
                       share_of(touching, apart + touching),
                       middle(all.felt_),
                       largest(all.felt_),
                       {}};
  for (const Term term : kAllTerms)
    if (all.present_[static_cast<std::size_t>(term)]) history.terms.push_back(all.activity(term));
  return history;
}

ForceHistory force_history(const Episode& episode, const Scene& scene) {
  return force_history({InsertionForces(episode, scene)});
}

}  // namespace ferrule
