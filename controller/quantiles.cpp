#include "controller/quantiles.hpp"

#include <cmath>
#include <limits>

#include "controller/statistics.hpp"
#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

constexpr double kUnit = 2 * Quantiles::kWithin;
constexpr long kNotPositive = std::numeric_limits<long>::min();

long rounded(double x) {
  return x > 0 ? std::lround(elementary::log(x) / kUnit) : kNotPositive;
}

double number_of(long key) {
  return key == kNotPositive ? 0.0 : elementary::exp(kUnit * static_cast<double>(key));
}

}  // namespace

void Quantiles::add(double x) {
  ++count_;
  if (count_ <= kExact) {
    exact_.push_back(x);
    return;
  }
  for (const double before : exact_) ++rounded_[rounded(before)];
  exact_ = {};
  ++rounded_[rounded(x)];
}

double Quantiles::operator()(double p) const {
  if (count_ <= kExact) return quantile(exact_, p);
  const double place = p * static_cast<double>(count_ - 1);
  const auto below = static_cast<std::size_t>(place);
  const double share = place - static_cast<double>(below);
  double low = NAN;
  std::size_t passed = 0;
  for (const auto& [key, count] : rounded_) {
    passed += count;
    if (std::isnan(low) && passed > below) low = number_of(key);
    if (share == 0 && !std::isnan(low)) return low;
    if (passed > below + 1) return low + share * (number_of(key) - low);
  }
  return low;
}

}  // namespace ferrule
