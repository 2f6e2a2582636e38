// Which of the things that chance decides decides the result: total Sobol indices.
//
// The total index of one of several independent things that chance decides is the share of the
// variance of a result f that would be left, on average, if all the others were known:
//   T = E[Var(f | all others)]/Var(f) = E[(f - f')^2]/(2 Var(f)),
// f and f' with that thing drawn twice and all the others the same (Sobol 1993; Jansen 1999, as
// Saltelli et al. 2010, table 2 (f)). 0: it does not matter. As each takes a share of what it does
// together with others, they add up to 1 or more.
#pragma once

#include <cstdint>
#include <vector>

#include "controller/statistics.hpp"

namespace ferrule {

// T [-] and its 95 % interval; NaN where all results are the same, or there are fewer than two pairs.
// The interval is that of the bootstrap (percentiles of 1000 samples of the pairs). Where no pair
// differs it ends at the index with three pairs more that differ by as much as any two results do:
// more of such pairs would hardly have been missed (the rule of three).
struct TotalIndex {
  double total;
  Interval interval;
};

// `f` and `again`, with one thing drawn again, of the same trials; pairs in which one is NaN are
// left out. Throws std::invalid_argument unless there are as many of both.
TotalIndex total_index(const std::vector<double>& f, const std::vector<double>& again,
                       std::uint64_t seed);

}  // namespace ferrule
