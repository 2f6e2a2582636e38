// Which of the things that chance decides decides the result: Sobol indices.
//
// Of one of several independent things that chance decides, the first-order index is the share of
// the variance of a result f that it makes by itself: by which the variance would fall, on average,
// if it were known. The total index is the share that would be left if all the others were known:
//   S = Var(E[f | it])/Var(f),    T = E[Var(f | all others)]/Var(f)
// (Sobol 1993; Homma and Saltelli 1996). T - S is what it does together with others. The S of all
// add up to 1 at most, and what is missing is interaction; each T has all that its thing does
// together with others, so that the T add up to 1 or more: they are not shares of a whole.
//
// From three results of each trial (Saltelli et al. 2010, table 2 (b) and (f)): f, as it is; f',
// with this thing drawn again and all the others the same; and g, all drawn again, this thing as in
// f':
//   S = mean((g - m)(f' - f))/V,    T = mean((f - f')^2)/(2 V)      (f): Jansen 1999
// with the mean m and the variance V of f and f'.
#pragma once

#include <cstdint>
#include <vector>

#include "controller/statistics.hpp"

namespace ferrule {

// S or T [-] and its 95 % interval; NaN where all results are the same, or there are fewer than two
// trials. S is an estimate that may fall below 0. The interval is that of the bootstrap (percentiles
// of 1000 samples of the trials). Where no f' differs from its f it ends at T with three trials more
// in which they differ by as much as any two results do: more of such trials would hardly have been
// missed (the rule of three).
struct SobolIndex {
  double index;
  Interval interval;
};

// Of the same trials; those in which one is NaN are left out. Throw std::invalid_argument unless
// there are as many of each.
SobolIndex total_index(const std::vector<double>& f, const std::vector<double>& again,
                       std::uint64_t seed);
SobolIndex first_order_index(const std::vector<double>& f, const std::vector<double>& again,
                             const std::vector<double>& all_again, std::uint64_t seed);

}  // namespace ferrule
