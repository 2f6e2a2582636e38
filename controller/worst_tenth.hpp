// Where a controller fails: by which of what chance decides, and in which tenth of that it inserts
// least.
#pragma once

#include <cmath>
#include <span>
#include <string>
#include <vector>

#include "controller/statistics.hpp"
#include "controller/trial.hpp"

namespace ferrule {

// What chance decided in each of the trials, by one number.
struct DrawnQuantity {
  std::string name;
  std::vector<double> values;
};

// The first `trials` trials under `seed`: how far the end starts from the bore's axis
// ("start.lateral_um") and how tilted ("start.tilt_mrad"), and each number that the scene draws, in
// its unit; those that are infeasible have NaN.
std::vector<DrawnQuantity> drawn_quantities(const Scene& scene, std::uint64_t seed,
                                            std::size_t trials);

// Trials between two values of a quantity.
struct Tenth {
  double low, high;
  std::size_t successes, trials;
};

// The quantity that success depends on most.
struct Deciding {
  std::string name;  // empty: no share is above 0, or there are no more than ten trials
  // Of the variance of success, between tenths of the trials sorted by the quantity, less what is
  // there by chance: epsilon squared (Kelley 1935). 1: it says which trials succeed.
  double share;
  std::vector<Tenth> tenths;
};

// Infeasible trials do not count.
Deciding deciding_quantity(const std::vector<DrawnQuantity>& drawn,
                           const std::vector<TrialResult>& results);

struct WorstTenth {
  std::string name = {};         // of the quantity; empty: there is none
  double low = NAN, high = NAN;  // between which it was there
  std::size_t successes = 0;     // there
  std::size_t trials = 0;

  double rate() const noexcept {  // NaN without a trial
    return trials > 0 ? static_cast<double>(successes) / static_cast<double>(trials) : NAN;
  }
  Interval interval() const {  // of it, 95 %
    return trials > 0 ? wilson(successes, trials) : Interval{0, 1};
  }
};

// The even trials, sorted by each quantity into ten parts, tell which part is the worst; the odd
// ones between its bounds, which did not choose it, how bad it is. Infeasible trials do not count.
WorstTenth worst_tenth(const std::vector<DrawnQuantity>& drawn,
                       std::span<const TrialResult> results);

}  // namespace ferrule
