#include "sim/laws/tilted_annulus.hpp"

#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr Annulus kRough = {62.5e-6, 63e-6, 2e-9};
constexpr VanDerWaals kAttraction = {3.67e-19};
constexpr Electrostatic kCharge = {0.1};

// The scalar law integrated by the midpoint rule along the straight line.
template <class Law>
double by_pieces(const Law& law, const Vector2d& a, const Vector2d& b) {
  const int n = 200000;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double s = (i + 0.5) / n;
    sum += law(kRough.clearance() - ((1 - s) * a + s * b).norm()).potential;
  }
  return sum / n;
}

struct Line {
  Vector2d a, b;
};

// Skew, in the plane, across the axis, parallel, and close to the wall at one end or both.
std::vector<Line> lines() {
  const double c = kRough.clearance();
  return {{{0.2 * c, 0.3 * c}, {-0.4 * c, 0.5 * c}},
          {{0.9 * c, 0}, {0.3 * c, 0}},
          {{0.99 * c, 0}, {-0.99 * c, 0}},
          {{0.5 * c, 0.1 * c}, {0.5 * c, 0.1 * c}},
          {{0.7 * c, 0.7 * c}, {0.7 * c, 0.6999 * c}},
          {{0, 0}, {0, 0.98 * c}}};
}

TEST(TiltedAnnulus, OfVanDerWaalsIsTheIntegralOfTheLaw) {
  const TiltedAnnulus law = TiltedAnnulus::of(&kAttraction, nullptr, kRough);
  for (const Line& l : lines())
    EXPECT_CLOSE(
        line_mean(law, l.a, l.b).value[0],
        by_pieces([](double h) { return van_der_waals(kAttraction, kRough, h); }, l.a, l.b), 1e-7);
}

TEST(TiltedAnnulus, OfElectrostaticsIsTheIntegralToTheErrorItStates) {
  const TiltedAnnulus law = TiltedAnnulus::of(nullptr, &kCharge, kRough);
  for (const Line& l : lines())
    EXPECT_CLOSE(line_mean(law, l.a, l.b).value[1],
                 by_pieces([](double h) { return electrostatic(kCharge, kRough, h); }, l.a, l.b),
                 closed_form_error(kRough) + 1e-8);
  EXPECT_LT(closed_form_error(kRough), 3e-6);
}

// To an error of the order of (C^2/(r R))^2 the exact cylinders are the closed form times 1 + t/12.
TEST(TiltedAnnulus, StatesTheErrorOfTheElectrostaticClosedForm) {
  const Annulus wide = {62.5e-6, 65e-6};
  const TiltedAnnulus law = TiltedAnnulus::of(nullptr, &kCharge, wide);
  const Vector2d centre = Vector2d::Zero();
  const double exact = electrostatic(kCharge, wide, wide.clearance()).potential;
  EXPECT_CLOSE(1 - line_mean(law, centre, centre).value[1] / exact, closed_form_error(wide), 1e-2);
}

TEST(TiltedAnnulus, LosesNoDigitsHoweverSmallTheTilt) {
  const TiltedAnnulus law = TiltedAnnulus::of(&kAttraction, &kCharge, kRough);
  const Vector2d e(0.6 * kRough.clearance(), 0.1 * kRough.clearance());
  const LineMean parallel = line_mean(law, e, e);
  for (double tilt = 1e-9; tilt > 1e-24; tilt *= 1e-2) {
    const Vector2d half(0, 0.5 * tilt);
    const LineMean tilted = line_mean(law, e - half, e + half);
    for (std::size_t i = 0; i < 2; ++i) {
      // The mean changes with the square of the tilt.
      const double relative = 10 * std::pow(tilt / kRough.clearance(), 2) + 1e-14;
      EXPECT_CLOSE(tilted.value[i], parallel.value[i], relative) << tilt;
    }
  }
}

TEST(TiltedAnnulus, GradientAndHessianAreDerivatives) {
  const TiltedAnnulus both = TiltedAnnulus::of(&kAttraction, &kCharge, kRough);
  const TiltedAnnulus charge = TiltedAnnulus::of(nullptr, &kCharge, kRough);
  for (const TiltedAnnulus& law : {both, charge})
    for (const Line& l : lines()) {
      const LineMean here = line_mean(law, l.a, l.b);
      const double near = kRough.clearance() - std::max(l.a.norm(), l.b.norm());
      const double h = 1e-4 * (near + kRough.roughness);
      const auto moved = [&](int coordinate, double d) {
        Line m = l;
        (coordinate < 2 ? m.a : m.b)[coordinate % 2] += d;
        return line_mean(law, m.a, m.b);
      };
      const auto total = [](const LineMean& m) { return m.value[0] + m.value[1]; };
      const auto gradient = [](const LineMean& m, int i) {
        return i < 2 ? m.by_a[0][i] + m.by_a[1][i] : m.by_b[0][i - 2] + m.by_b[1][i - 2];
      };
      Eigen::Matrix4d hessian;
      hessian << here.aa, here.ab, here.ba, here.bb;
      const double scale = std::max(std::abs(gradient(here, 0)) + std::abs(gradient(here, 1)),
                                    std::abs(gradient(here, 2)) + std::abs(gradient(here, 3)));
      for (int i = 0; i < 4; ++i) {
        const double slope =
            testing::derivative([&](double d) { return total(moved(i, d)); }, 0, h);
        EXPECT_LE(std::abs(gradient(here, i) - slope), 1e-8 * scale);
        for (int j = 0; j < 4; ++j) {
          const double curve =
              testing::derivative([&](double d) { return gradient(moved(i, d), j); }, 0, h);
          EXPECT_LE(std::abs(hessian(j, i) - curve), 1e-8 * hessian.cwiseAbs().maxCoeff());
        }
      }
    }
}

}  // namespace
}  // namespace ferrule
