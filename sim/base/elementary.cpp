#include "sim/base/elementary.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

namespace ferrule::elementary {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();

// Minimax polynomials, relative error below 2^-57.
// (e^r - 1 - r)/r^2, |r| <= log(2)/2
constexpr std::array<double, 11> kExp = {
    0.5,
    0.16666666666666677,
    0.0416666666666667,
    0.008333333333321615,
    0.0013888888888866832,
    0.00019841269886158755,
    2.4801587360568242e-05,
    2.7557244181768126e-06,
    2.7557242749043884e-07,
    2.5109044933709667e-08,
    2.092444648626437e-09,
};
// (log((1 + s)/(1 - s)) - 2 s)/s^3 of s^2, |s| <= (sqrt(2) - 1)/(sqrt(2) + 1)
constexpr std::array<double, 7> kLog = {
    0.6666666666666734,  0.39999999999414326, 0.2857142874247384, 0.22222198563570503,
    0.18183564862737678, 0.15314035926270983, 0.1479610463708204,
};
// (sin r - r)/r^3 and (cos r - 1 + r^2/2)/r^4 of r^2, |r| <= pi/4
constexpr std::array<double, 6> kSin = {
    -0.16666666666666632,   0.00833333333332242,     -0.00019841269829812535,
    2.7557313693613624e-06, -2.5050758389579453e-08, 1.5896812052782232e-10,
};
constexpr std::array<double, 6> kCos = {
    0.0416666666666666,    -0.0013888888888874131, 2.480158728948704e-05,
    -2.75573143537799e-07, 2.0875723476029083e-09, -1.135965861803576e-11,
};
// (atan t - t)/t^3 of t^2, |t| <= 7/16
constexpr std::array<double, 11> kAtan = {
    -0.3333333333333293,  0.19999999999876045, -0.14285714272469469,  0.11111110404089258,
    -0.0909088710061347,  0.07691875710447964, -0.06661068312115374,  0.05833539714720287,
    -0.04976758407951889, 0.03652890761675635, -0.016283249353555462,
};
// (1 + d)^(-1/3), -0.105 <= d <= 0.115, to 2^-22
constexpr std::array<double, 5> kCubeRoot = {
    0.9999999793685028,   -0.3333277353126572, 0.22224024033345244,
    -0.17470733331222005, 0.14301061736709986,
};

// log(2), its first part of 40 bits: multiples by exponents are exact.
constexpr double kLog2 = 0x1.62e42fefa2p-1, kLog2Rest = 0x1.9ef35793c7673p-41;
// pi/2 of two parts of 33 bits and the rest: multiples up to 2^20 of the first two are exact.
constexpr double kHalfPi = 0x1.921fb544p+0, kHalfPi2 = 0x1.0b4611a6p-34,
                 kHalfPi3 = 0x1.3198a2e037073p-69;
constexpr double kLargestAngle = 1e6;

// The polynomial c at x, by pairs, pairs of pairs and so on (Estrin): a short chain of operations.
template <std::size_t n>
inline double sum_of_powers(const std::array<double, n>& c, double x) noexcept {
  if constexpr (n == 1) {
    return c[0];
  } else {
    std::array<double, (n + 1) / 2> pairs;
    for (std::size_t k = 0; k < n / 2; ++k) pairs[k] = c[2 * k] + x * c[2 * k + 1];
    if constexpr (n % 2 == 1) pairs.back() = c.back();
    return sum_of_powers(pairs, x * x);
  }
}

// To the nearest whole number, |x| < 2^51.
inline double nearest(double x) noexcept {
  constexpr double kShift = 0x1.8p52;
  return (x + kShift) - kShift;
}

// 2^k, -1022 <= k <= 1023.
inline double power_of_two(std::int64_t k) noexcept {
  return std::bit_cast<double>(static_cast<std::uint64_t>(k + 1023) << 52);
}

// e^x = 2^exponent (1 + rest).
struct Power {
  std::int64_t exponent;
  double rest;
};

inline Power reduced_power(double x) noexcept {
  const double k = nearest(x * std::numbers::log2e);
  const double r = (x - k * kLog2) - k * kLog2Rest;
  return {static_cast<std::int64_t>(k), r + r * r * sum_of_powers(kExp, r)};
}

// log(2^k (1 + f)), 1 + f between kLeastFraction and twice that.
constexpr double kLeastFraction = 0.5 * std::numbers::sqrt2;
inline double log_of(double k, double f) noexcept {
  // log(1 + f) = f - (f^2/2 - s (f^2/2 + R(s^2))), s = f/(2 + f)
  const double s = f / (2 + f), z = s * s, half = 0.5 * f * f;
  const double R = z * sum_of_powers(kLog, z);
  return k * kLog2 - ((half - (s * (half + R) + k * kLog2Rest)) - f);
}

// x = turns pi/2 + high + low, |high| <= pi/4.
struct Angle {
  double high, low;
  int quadrant;
};

inline Angle reduced_angle(double x) noexcept {
  if (std::abs(x) > kLargestAngle) x = std::fmod(x, 2 * std::numbers::pi);
  if (!(std::abs(x) <= kLargestAngle)) return {kNotANumber, 0, 0};
  if (std::abs(x) <= std::numbers::pi / 4) return {x, 0, 0};
  const double turns = nearest(x * (2 / std::numbers::pi));
  const double first = x - turns * kHalfPi, second = turns * kHalfPi2;
  const double rest = first - second;
  const double lost = ((first - rest) - second) - turns * kHalfPi3;
  const double high = rest + lost;
  return {high, (rest - high) + lost, static_cast<int>(static_cast<std::int64_t>(turns) & 3)};
}

inline double sine(const Angle& a) noexcept {
  const double z = a.high * a.high;
  return a.high + (a.high * z * sum_of_powers(kSin, z) + a.low * (1 - 0.5 * z));
}

inline double cosine(const Angle& a) noexcept {
  const double z = a.high * a.high, half = 0.5 * z, first = 1 - half;
  return first + (((1 - first) - half) + (z * z * sum_of_powers(kCos, z) - a.high * a.low));
}

}  // namespace

double exp(double x) noexcept {
  if (!(x < 710)) return x > 0 ? kInfinite : x;
  if (x < -746) return 0;
  const Power power = reduced_power(x);
  const double value = 1 + power.rest;
  if (power.exponent >= -1022 && power.exponent <= 1023)
    return value * power_of_two(power.exponent);
  const std::int64_t half = power.exponent / 2;
  return value * power_of_two(half) * power_of_two(power.exponent - half);
}

double expm1(double x) noexcept {
  if (!(std::abs(x) < 700)) return exp(x) - 1;
  const Power power = reduced_power(x);
  const double scale = power_of_two(power.exponent);
  return scale * power.rest + (scale - 1);
}

double log(double x) noexcept {
  if (!(x > 0)) return x == 0 ? -kInfinite : kNotANumber;
  if (x == kInfinite) return x;
  double k = 0;
  if (x < std::numeric_limits<double>::min()) {
    x *= 0x1p54;
    k = -54;
  }
  const auto bits = std::bit_cast<std::int64_t>(x);
  const std::int64_t exponent = (bits - std::bit_cast<std::int64_t>(kLeastFraction)) >> 52;
  k += static_cast<double>(exponent);
  return log_of(k, std::bit_cast<double>(bits - (exponent << 52)) - 1);
}

double log1p(double x) noexcept {
  if (x > kLeastFraction - 1 && x < 2 * kLeastFraction - 1) return log_of(0, x);
  const double u = 1 + x;
  if (!(u > 0) || u == kInfinite) return log(u);
  const double lost = x < 1 ? x - (u - 1) : 1 - (u - x);
  return log(u) + lost / u;
}

double cbrt(double x) noexcept {
  if (x == 0 || !(std::abs(x) < kInfinite)) return x;
  double size = std::abs(x), scale = 1;
  if (size < std::numeric_limits<double>::min()) {
    size *= 0x1p54;
    scale = 0x1p-18;
  }
  // A third of the exponent: 4 %. The polynomial: 22 bits. A step of Halley's, with t^2 exact: all.
  double t = std::bit_cast<double>(std::bit_cast<std::uint64_t>(size) / 3 + 0x2a9f789300000000u);
  t *= sum_of_powers(kCubeRoot, t * t * (t / size) - 1);
  t = std::bit_cast<double>((std::bit_cast<std::uint64_t>(t) + (1u << 26)) & ~((1ull << 27) - 1));
  const double per_square = size / (t * t);
  t += t * ((per_square - t) / (t + t + per_square));
  return std::copysign(scale * t, x);
}

double sin(double x) noexcept {
  const Angle a = reduced_angle(x);
  const double value = a.quadrant & 1 ? cosine(a) : sine(a);
  return a.quadrant & 2 ? -value : value;
}

double cos(double x) noexcept {
  const Angle a = reduced_angle(x);
  const double value = a.quadrant & 1 ? sine(a) : cosine(a);
  return (a.quadrant + 1) & 2 ? -value : value;
}

double tan(double x) noexcept {
  const Angle a = reduced_angle(x);
  return a.quadrant & 1 ? -cosine(a) / sine(a) : sine(a) / cosine(a);
}

double atan(double x) noexcept {
  // atan |x| = atan c + atan t, t = (|x| - c)/(1 + c |x|); c and both parts of atan c.
  const double size = std::abs(x);
  double t = size, high = 0, low = 0;
  if (size > 2.4375) {
    t = -1 / size;
    high = 0x1.921fb54442d18p+0, low = 0x1.1a62633145c07p-54;
  } else if (size > 1.1875) {
    t = (size - 1.5) / (1 + 1.5 * size);
    high = 0x1.f730bd281f69bp-1, low = 0x1.007887af0cbbdp-56;
  } else if (size > 0.6875) {
    t = (size - 1) / (1 + size);
    high = 0x1.921fb54442d18p-1, low = 0x1.1a62633145c07p-55;
  } else if (size > 0.4375) {
    t = (2 * size - 1) / (2 + size);
    high = 0x1.dac670561bb4fp-2, low = 0x1.a2b7f222f65e2p-56;
  }
  const double z = t * t;
  return std::copysign(high + (t + (t * z * sum_of_powers(kAtan, z) + low)), x);
}

}  // namespace ferrule::elementary
