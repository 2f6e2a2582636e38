// The few statistics a campaign reports.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace ferrule {

struct Interval {
  double low, high;
};

// Of a standard normal variable, what 97.5 % do not exceed: half a 95 % interval is so many standard
// deviations.
double two_sided_z();

// 95 % Wilson interval of a success rate (Wilson 1927). 0 <= successes <= trials, trials > 0.
Interval wilson(std::size_t successes, std::size_t trials);

// Further trials, at the success rate so far, until the lower end of that interval reaches `rate`,
// 0 < rate < 1; 0: it has. Empty: it never does, the success rate being no higher.
std::optional<std::size_t> trials_to_show(double rate, std::size_t successes, std::size_t trials);

// Evidence that a success rate is above (below) `rate`, 0 < rate < 1: the mean of L(p)/L(rate) over
// the rates p uniform in (rate, 1) (in (0, rate)), with the likelihood L(p) = p^s (1 - p)^f of s
// successes and f failures. Begins at 1, without trials. Under every rate that is not above (not
// below) it, the chance that it ever reaches 1/a is at most a, however many trials are run and
// whenever they are looked at (Ville 1939; of such mixtures: Robbins 1970). In terms of binomial
// numbers X(n) of successes at that rate it is P(X(n+1) <= s)/((n + 1) (1 - rate) P(X(n) = s)),
// and P(X(n+1) > s)/((n + 1) rate P(X(n) = s)); 0 or infinity beyond the range of doubles.
double evidence_above(double rate, std::size_t successes, std::size_t trials);
double evidence_below(double rate, std::size_t successes, std::size_t trials);

// Two-sided exact McNemar test (McNemar 1947, binomial form): p of `only_a` and `only_b` discordant
// pairs under equal rates. 1 if there are none.
double mcnemar_p(std::size_t only_a, std::size_t only_b);

// Quantile q of values (linear interpolation between order statistics, R's type 7); NaN if empty.
double quantile(std::vector<double> values, double q);

// 95 % interval of the median of what the values were drawn from, whatever its distribution:
// between two of the values (those that the sign test would not reject). NaN for fewer than 6.
Interval median_interval(std::vector<double> values);

}  // namespace ferrule
