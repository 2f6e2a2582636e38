#include "sim/laws/quadrature.hpp"

#include "sim/laws/van_der_waals.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

TEST(Quadrature, IsExactForPolynomialsOfItsDegree) {
  for (const int order : {1, 2, 3, 5, 8, 16, 32}) {
    const Quadrature q = Quadrature::gauss_legendre(order);
    for (int degree = 0; degree < 2 * order; ++degree) {
      double sum = 0;
      for (std::size_t n = 0; n < static_cast<std::size_t>(order); ++n)
        sum += q.weight[n] * std::pow(q.node[n], degree);
      EXPECT_CLOSE(sum, 1.0 / (degree + 1), 1e-12) << order << " " << degree;
    }
  }
}

// Between tilted axes the van der Waals force converges with the order.
TEST(Quadrature, ConvergesForTiltedAxes) {
  const VanDerWaals law = {3.67e-19};
  const Annulus rough = {62.5e-6, 63e-6, 5e-9};
  const auto force = [&](int order) {
    const Quadrature q = Quadrature::gauss_legendre(order);
    double sum = 0;
    for (std::size_t n = 0; n < static_cast<std::size_t>(order); ++n)
      sum += q.weight[n] * van_der_waals(law, rough, 5e-9 + 40e-9 * q.node[n]).force;
    return sum;
  };
  const double exact = force(32);
  double before = 2;
  for (const int order : {1, 2, 4, 8, 16}) {
    const double error = std::abs(force(order) / exact - 1);
    EXPECT_LT(error, 0.5 * before) << order;
    before = error;
  }
  EXPECT_LT(before, 1e-5);
}

}  // namespace
}  // namespace ferrule
