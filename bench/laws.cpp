#include "bench/laws.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "bench/measure.hpp"
#include "sim/laws/adhesion.hpp"
#include "sim/laws/capillary.hpp"
#include "sim/laws/electrostatic.hpp"
#include "sim/laws/quadrature.hpp"
#include "sim/laws/tilted_annulus.hpp"
#include "sim/laws/van_der_waals.hpp"

namespace ferrule {
namespace {

using Real = long double;
constexpr Real pi = std::numbers::pi_v<Real>;
constexpr Annulus kRough = {62.5e-6, 63e-6, 5e-9};
constexpr double kHamaker = 3.67e-19, kVoltage = 0.1;
constexpr Capillary kBridge = {0.072, std::numbers::pi / 3, 80e-9, 4e-12, 600e-9};

std::vector<double> gaps() {
  std::vector<double> all;
  for (int i = 0; i < 64; ++i) all.push_back(1e-9 * std::pow(450.0, i / 63.0));
  return all;
}

// Half spaces with H/(6 pi g^3) on every part of the circumference, g = c - e cos(angle).
Real annulus_integral(double h) {
  const Real c = static_cast<Real>(kRough.clearance()) + kRough.roughness;
  const Real near = static_cast<Real>(h) + kRough.roughness, e = c - near;
  Real sum = 0;
  const int n = 20000;  // periodic and smooth: the midpoint rule converges exponentially
  for (int i = 0; i < n; ++i) {
    const Real half = pi * (i + 0.5L) / n;  // half the angle: 1 - cos = 2 sin^2
    const Real g = near + 2 * e * std::sin(half) * std::sin(half);
    sum += (1 - 2 * std::sin(half) * std::sin(half)) / (g * g * g);
  }
  return -static_cast<Real>(kHamaker) / (6 * pi) * kRough.fibre_radius * sum * 2 * pi / n;
}

Real cylinders(double h) {
  const Real c = static_cast<Real>(kRough.clearance()) + kRough.roughness;
  const Real near = static_cast<Real>(h) + kRough.roughness, e = c - near;
  const Real r = kRough.fibre_radius, product = r * (r + c);
  const Real t = near * (c + e) / (2 * product), root = std::sqrt(t * (2 + t));
  const Real angle = std::log1p(t + root);
  return -pi * 8.8541878128e-12L * kVoltage * kVoltage * e / (product * angle * angle * root);
}

Real bridge(double h) {
  const Real radius =
      static_cast<Real>(kRough.fibre_radius) * kRough.bore_radius / kRough.clearance();
  Real low = 0, high = 1e-3L;
  for (int i = 0; i < 200; ++i) {
    const Real x = (low + high) / 2;
    (2 * (h * x + x * x * x / (6 * radius)) < kBridge.volume ? low : high) = x;
  }
  return -4 * kBridge.surface_tension * std::cos(static_cast<Real>(kBridge.contact_angle)) * low /
         (h + low * low / (2 * radius));
}

double largest(const std::function<Real(double)>& exact, const std::function<double(double)>& law,
               const std::vector<double>& at) {
  Real worst = 0;
  for (const double x : at) {
    const Real reference = exact(x);
    worst = std::max(worst, std::abs((static_cast<Real>(law(x)) - reference) / reference));
  }
  return static_cast<double>(worst);
}

}  // namespace

std::vector<LawRow> bench_laws() {
  std::vector<LawRow> rows;
  const std::vector<double> at = gaps();
  const auto gap = [&](long i) { return at[static_cast<std::size_t>(i) & 63]; };

  const VanDerWaals annulus = {kHamaker};
  // The printed patch with the right factor, across gap and roughness.
  const auto patch = [](double h) {
    return 4 * printed::van_der_waals({kHamaker}, kRough, h + kRough.roughness).force;
  };
  rows.push_back({"van_der_waals", "patch",
                  nanoseconds_per_call([&](long i) { keep(patch(gap(i))); }),
                  largest(annulus_integral, patch, at)});
  rows.push_back({"van_der_waals", "annulus closed form", nanoseconds_per_call([&](long i) {
                    keep(van_der_waals(annulus, kRough, gap(i)));
                  }),
                  largest(
                      annulus_integral,
                      [&](double h) { return van_der_waals(annulus, kRough, h).force; }, at)});
  const Real length = 1e-3L, tilt = 0.2e-3L;
  Real tilted = 0;
  for (int i = 0; i < 400000; ++i)
    tilted += van_der_waals(annulus, kRough,
                            static_cast<double>(5e-9L + tilt * length * (i + 0.5L) / 400000))
                  .force /
              400000.0L;
  for (const int order : {1, 2, 3, 5, 8, 16, 32}) {
    const Quadrature q = Quadrature::gauss_legendre(order);
    const auto integrate = [&](double from) {
      double sum = 0;
      for (std::size_t n = 0; n < static_cast<std::size_t>(order); ++n)
        sum += q.weight[n] *
               van_der_waals(annulus, kRough, from + static_cast<double>(tilt * length) * q.node[n])
                   .force;
      return sum;
    };
    rows.push_back({"van_der_waals", "tilted quadrature of order " + std::to_string(order),
                    nanoseconds_per_call([&](long i) { keep(integrate(5e-9 + 1e-15 * (i & 7))); }),
                    static_cast<double>(std::abs(integrate(5e-9) / tilted - 1))});
  }

  const Electrostatic exact = {kVoltage};
  // The closed forms along the same tilted length: energies at the ends' eccentricities.
  const double clearance = kRough.clearance();
  const Vector2d far(clearance - 5e-9 - static_cast<double>(tilt * length), 0);
  const Vector2d near(clearance - 5e-9, 0);
  const auto closed_form = [&](const TiltedAnnulus& law, std::size_t which) {
    const LineMean mean = line_mean(law, near, far);
    return mean.by_a[which].x() + mean.by_b[which].x();
  };
  const TiltedAnnulus attraction = TiltedAnnulus::of(&annulus, nullptr, kRough);
  rows.push_back({"van_der_waals", "tilted closed form, with Hessian",
                  nanoseconds_per_call([&](long) { keep(closed_form(attraction, 0)); }),
                  static_cast<double>(std::abs(closed_form(attraction, 0) / tilted - 1))});
  const auto plates = [](double h) {
    return printed::electrostatic({kVoltage}, kRough, h + kRough.roughness).force;
  };
  rows.push_back({"electrostatic", "patch",
                  nanoseconds_per_call([&](long i) { keep(plates(gap(i))); }),
                  largest(cylinders, plates, at)});
  rows.push_back(
      {"electrostatic", "exact cylinders",
       nanoseconds_per_call([&](long i) { keep(electrostatic(exact, kRough, gap(i))); }),
       largest(
           cylinders, [&](double h) { return electrostatic(exact, kRough, h).force; }, at)});
  Real charged = 0;
  for (int i = 0; i < 400000; ++i)
    charged +=
        cylinders(static_cast<double>(5e-9L + tilt * length * (i + 0.5L) / 400000)) / 400000.0L;
  const TiltedAnnulus charge = TiltedAnnulus::of(nullptr, &exact, kRough);
  rows.push_back({"electrostatic", "tilted closed form, with Hessian",
                  nanoseconds_per_call([&](long) { keep(closed_form(charge, 1)); }),
                  static_cast<double>(std::abs(closed_form(charge, 1) / charged - 1))});
  rows.push_back(
      {"capillary", "bridge of constant volume",
       nanoseconds_per_call([&](long i) { keep(capillary(kBridge, kRough, gap(i), true)); }),
       largest(
           bridge, [&](double h) { return capillary(kBridge, kRough, h, true).force; }, at)});

  // Maugis: depth to force at lambda = 4.
  const MaugisCurve curve(4);
  std::vector<double> depths;
  double table_error = 0;
  for (int i = 0; i < 64; ++i) {
    const MaugisPoint p = maugis_at_radius(4, 0.7 + 0.1 * i);
    depths.push_back(p.D);
    table_error =
        std::max(table_error, std::abs(curve.at(p.D, 1).P - p.P) / std::max(0.1, std::abs(p.P)));
  }
  rows.push_back({"adhesion", "Maugis table, force slope energy radius",
                  nanoseconds_per_call(
                      [&](long i) { keep(curve.at(depths[static_cast<std::size_t>(i) & 63], 1)); }),
                  table_error});
  return rows;
}

}  // namespace ferrule
