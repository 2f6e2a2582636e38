// Which force acted when in a recording, and which of them the hand could feel.
//
// The hand feels the wrench of the fibre on the holder relative to that of the first row, at rest
// (insertion/sensed_wrench.hpp). With dF_k the force of term k less that of the first row, dN the
// holder's, n = dN/|dN| and P the sum of all dF_k n that are positive, term k reaches the hand with
//   f_k = max(0, dF_k n) min(1, |dN|/P)
// Terms that pull against dN are balanced within the ferrule by those that push along it, and take
// the same share of each: an adhesion that a wall holds reaches no hand. At rest, sum of f_k =
// |dN|.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "capture/episode.hpp"

namespace ferrule {

// A change of force that a hand notices: a tenth of the force that is there (Pang, Tan and Durlach
// 1991, "Manual discrimination of force using active finger motion": 5 to 10 %; Allin, Matsuoka and
// Klatzky 2002, "Measuring just noticeable differences for haptic force feedback": 10 %), and not
// below 0.1 N, assumed.
inline constexpr double kNoticedShare = 0.1;  // [-]
inline constexpr double kNoticedForce = 0.1;  // in the hand's world [N]

// Does the end or the side touch in that row?
bool touches(const RowVector& row) noexcept;

struct TermActivity {
  Term term;
  // Shares of the rows in which the term is not zero [-]: of all, of those in which nothing touches
  // and of those in which end or side do; NaN where there is no such row.
  double acts, apart, touching;
  // Time of the first and of the last of them, of several insertions in which it acts the median
  // [s]; NaN: it never acts.
  double first, last;
  double median, largest;  // of its magnitude, both places added up, where it acts [N]; 0: never
  double reaches;          // sum of f_k over sum of |F_k| [-]; NaN: it never acts
  double of_felt;          // sum of f_k over sum of |dN| [-]; NaN: nothing is felt
  double noticed;  // share of all rows in which f_k, scaled to the hand, is one that is noticed [-]
};

struct ForceHistory {
  std::size_t insertions;            // that have a row
  double touching;                   // share of the rows in which end or side touch [-]
  double felt_median, felt_largest;  // |dN| [N]
  std::vector<TermActivity> terms;   // those that the scene has, in order
};

// One insertion in `scene` as its rows come; it may have none.
class InsertionForces {
 public:
  explicit InsertionForces(const Scene& scene);
  // All rows of an episode recorded in `scene`.
  InsertionForces(const Episode& episode, const Scene& scene);
  // In the order of time; the first row is at rest.
  void add(const RowVector& row);

 private:
  friend ForceHistory force_history(std::vector<InsertionForces> insertions);
  struct Sums {
    std::vector<double> magnitudes;     // [N]
    std::vector<double> first, last;    // of each insertion [s]
    std::array<std::size_t, 2> acts{};  // rows: apart, touching
    double sum = 0, reaching = 0;       // [N]
    std::size_t noticed = 0;            // rows
  };
  void append(const InsertionForces& other);
  TermActivity activity(Term term) const;

  double to_hand_;
  std::array<bool, kTerms> present_{};
  std::array<Sums, kTerms> terms_;
  std::optional<RowVector> rest_;
  std::size_t insertions_ = 0;
  std::array<std::size_t, 2> rows_{};  // apart, touching
  std::vector<double> felt_;           // [N]
};

// Of one insertion or several.
ForceHistory force_history(std::vector<InsertionForces> insertions);
ForceHistory force_history(const Episode& episode, const Scene& scene);

}  // namespace ferrule
