#include "sim/laws/quadrature.hpp"

#include <boost/math/special_functions/legendre.hpp>
#include <cassert>

namespace ferrule {

Quadrature Quadrature::gauss_legendre(int order) {
  assert(order >= 1 && order <= kMostNodes);
  Quadrature q;
  q.order = order;
  const auto zeros = boost::math::legendre_p_zeros<double>(order);  // the non-negative ones
  std::size_t n = 0;
  const auto add = [&](double x) {
    const double slope = boost::math::legendre_p_prime(order, x);
    q.node[n] = 0.5 * (1 + x);
    q.weight[n] = 1 / ((1 - x * x) * slope * slope);
    ++n;
  };
  for (auto zero = zeros.rbegin(); zero != zeros.rend(); ++zero)
    if (*zero > 0) add(-*zero);
  for (const double zero : zeros) add(zero);
  return q;
}

}  // namespace ferrule
