// The few statistics a campaign reports.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace ferrule {

struct Interval {
  double low, high;
};

// 95 % Wilson interval of a success rate (Wilson 1927). 0 <= successes <= trials, trials > 0.
Interval wilson(std::size_t successes, std::size_t trials);

// Further trials, at the success rate so far, until the lower end of that interval reaches `rate`,
// 0 < rate < 1; 0: it has. Empty: it never does, the success rate being no higher.
std::optional<std::size_t> trials_to_show(double rate, std::size_t successes, std::size_t trials);

// Two-sided exact McNemar test (McNemar 1947, binomial form): p of `only_a` and `only_b` discordant
// pairs under equal rates. 1 if there are none.
double mcnemar_p(std::size_t only_a, std::size_t only_b);

// Quantile q of values (linear interpolation between order statistics, R's type 7); NaN if empty.
double quantile(std::vector<double> values, double q);

// 95 % interval of the median of what the values were drawn from, whatever its distribution:
// between two of the values (those that the sign test would not reject). NaN for fewer than 6.
Interval median_interval(std::vector<double> values);

}  // namespace ferrule
