#include "sim/laws/quadrature.hpp"

#include <boost/math/special_functions/legendre.hpp>
#include <cassert>
#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {

// The zeros by Newton's method, from where they nearly are (Tricomi 1950); Boost's own search
// starts from the C library's cosine.
Quadrature Quadrature::gauss_legendre(int order) {
  assert(order >= 1 && order <= kMostNodes);
  Quadrature q;
  q.order = order;
  for (int n = 0; n < order; ++n) {
    double x = -elementary::cos(std::numbers::pi * (n + 0.75) / (order + 0.5));
    if (2 * n + 1 == order) x = 0;
    for (int i = 0; i < 5; ++i)
      x -= boost::math::legendre_p(order, x) / boost::math::legendre_p_prime(order, x);
    const double slope = boost::math::legendre_p_prime(order, x);
    q.node[static_cast<std::size_t>(n)] = 0.5 * (1 + x);
    q.weight[static_cast<std::size_t>(n)] = 1 / ((1 - x * x) * slope * slope);
  }
  return q;
}

}  // namespace ferrule
