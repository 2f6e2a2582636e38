// Elementary functions whose result is the same on every x86-64 processor. Those of the C library
// are not: glibc chooses at run time, by the processor, between versions that differ in the last
// bit. These are sums, products and quotients of doubles in a fixed order, so that they are the
// same wherever arithmetic is that of IEEE 754, rounded to nearest, and the compiler contracts
// nothing (-ffp-contract=off, cmake/ferrule_library.cmake). Whatever is simulated, recorded,
// learned or evaluated uses these; sqrt, floor, round and fmod are exact by IEEE 754 and stay
// std::.
//
// Methods: reduction of the argument by Cody and Waite (Software Manual for the Elementary
// Functions, 1980), then a minimax polynomial (Remez) of the rest, as in Muller, Elementary
// Functions, 2016, chapters 3, 4 and 11. The bounds are in units of the last place (ulp) of the
// result, and hold for all arguments but where stated; a NaN gives a NaN. None throws.
#pragma once

namespace ferrule::elementary {

// e^x, 1 ulp: infinity from 709.79 on, 0 below -745.14; within 1 ulp of the least normal number
// between -745.14 and -708.39, where the result is subnormal.
[[gnu::const]] double exp(double x) noexcept;

// The same of a dual number, with the value a and the derivatives v (ceres::Jet).
template <class Dual>
requires requires(Dual x) {
  x.a, x.v;
}
Dual exp(const Dual& x) {
  Dual y = x;
  y.a = exp(x.a);
  y.v *= y.a;
  return y;
}

// e^x - 1, 2 ulp, also where x is small.
[[gnu::const]] double expm1(double x) noexcept;

// Natural logarithm, 1 ulp. -infinity at 0, NaN below.
[[gnu::const]] double log(double x) noexcept;

// log(1 + x), 2 ulp, also where x is small. -infinity at -1, NaN below.
[[gnu::const]] double log1p(double x) noexcept;

// Real cube root, 1 ulp.
[[gnu::const]] double cbrt(double x) noexcept;

// Of x [rad], 1 ulp, tan 3 ulp; nearer than 1e-15 to a zero or a pole an absolute error of x of
// 1e-28 instead. For |x| > 1e6 they are those of an x that differs by less than half an ulp.
// NaN where x is infinite.
[[gnu::const]] double sin(double x) noexcept;
[[gnu::const]] double cos(double x) noexcept;
[[gnu::const]] double tan(double x) noexcept;

// [rad] in [-pi/2, pi/2], 1 ulp.
[[gnu::const]] double atan(double x) noexcept;

}  // namespace ferrule::elementary
