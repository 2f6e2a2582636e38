// Gauss-Legendre quadrature on [0, 1], for surface forces between tilted axes.
#pragma once

#include <array>

namespace ferrule {

inline constexpr int kMostNodes = 32;

struct Quadrature {
  int order = 1;
  std::array<double, kMostNodes> node{0.5}, weight{1.0};

  // 1 <= order <= kMostNodes; exact for polynomials of degree 2 order - 1.
  static Quadrature gauss_legendre(int order);
};

}  // namespace ferrule
