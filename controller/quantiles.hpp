// Quantiles of numbers that come one by one, in memory that does not grow with them: exactly
// (statistics.hpp) of up to kExact numbers; of more, each counts as rounded to within kWithin of
// itself.
#pragma once

#include <cstddef>
#include <map>
#include <vector>

namespace ferrule {

class Quantiles {
 public:
  static constexpr std::size_t kExact = 1 << 20;
  static constexpr double kWithin = 1e-4;

  void add(double x);
  // 0 <= p <= 1; NaN of no numbers.
  double operator()(double p) const;
  std::size_t count() const noexcept { return count_; }

 private:
  std::vector<double> exact_;
  // Numbers by their logarithm in units of 2 kWithin; those that are not positive by kNotPositive.
  std::map<long, std::size_t> rounded_;
  std::size_t count_ = 0;
};

}  // namespace ferrule
