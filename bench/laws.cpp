#include "bench/laws.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "sim/base/measure.hpp"
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

constexpr std::size_t kPoints = 64;  // gaps, or depths

const std::vector<double> kGaps = [] {
  std::vector<double> all;
  for (std::size_t i = 0; i < kPoints; ++i)
    all.push_back(1e-9 * std::pow(450.0, static_cast<double>(i) / (kPoints - 1)));
  return all;
}();

// One after the other, again and again.
double one_of(const std::vector<double>& points, long i) {
  return points[static_cast<std::size_t>(i) % kPoints];
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

double largest_error(const std::function<Real(double)>& exact,
                     const std::function<double(double)>& force) {
  Real worst = 0;
  for (const double x : kGaps) {
    const Real reference = exact(x);
    worst = std::max(worst, std::abs((static_cast<Real>(force(x)) - reference) / reference));
  }
  return static_cast<double>(worst);
}

// A law of the gap, timed, and its `force` [N/m] held against the exact one.
template <class Law>
LawRow across_gaps(const char* name, const char* fidelity, const std::function<Real(double)>& exact,
                   const Law& law, const std::function<double(double)>& force) {
  return {name, fidelity, nanoseconds_per_call([&](long i) { keep(law(one_of(kGaps, i))); }),
          largest_error(exact, force)};
}
template <class Law>
LawRow across_gaps(const char* name, const char* fidelity, const std::function<Real(double)>& exact,
                   const Law& law) {
  return across_gaps(name, fidelity, exact, law, [&](double h) { return law(h).force; });
}

// A length along which the gap widens from kFrom.
constexpr Real kLength = 1e-3L, kTilt = 0.2e-3L, kFrom = 5e-9L;
constexpr double kRise = static_cast<double>(kTilt * kLength);

// The mean of `force` along it.
template <class Force>
Real tilted_mean(const Force& force) {
  constexpr int kPieces = 400000;
  Real mean = 0;
  for (int i = 0; i < kPieces; ++i)
    mean += force(static_cast<double>(kFrom + kTilt * kLength * (i + 0.5L) / kPieces)) /
            static_cast<Real>(kPieces);
  return mean;
}

// The mean force along it in closed form: energies at the eccentricities of the ends.
double closed_form(const TiltedAnnulus& law, std::size_t which) {
  const double near_end = kRough.clearance() - 5e-9;
  const LineMean mean = line_mean(law, Vector2d(near_end, 0), Vector2d(near_end - kRise, 0));
  return mean.by_a[which].x() + mean.by_b[which].x();
}

LawRow tilted_closed_form(const char* name, const TiltedAnnulus& law, std::size_t which,
                          Real reference) {
  return {name, "tilted closed form, with Hessian",
          nanoseconds_per_call([&](long) { keep(closed_form(law, which)); }),
          static_cast<double>(std::abs(closed_form(law, which) / reference - 1))};
}

LawRow tilted_quadrature(const VanDerWaals& law, int order, Real reference) {
  const Quadrature q = Quadrature::gauss_legendre(order);
  const auto integrate = [&](double from) {
    double sum = 0;
    for (std::size_t n = 0; n < static_cast<std::size_t>(order); ++n)
      sum += q.weight[n] * van_der_waals(law, kRough, from + kRise * q.node[n]).force;
    return sum;
  };
  return {"van_der_waals", "tilted quadrature of order " + std::to_string(order),
          nanoseconds_per_call([&](long i) { keep(integrate(5e-9 + 1e-15 * (i & 7))); }),
          static_cast<double>(std::abs(integrate(5e-9) / reference - 1))};
}

void add_van_der_waals(std::vector<LawRow>& rows) {
  const VanDerWaals law = {kHamaker};
  // The printed patch with the right factor, across gap and roughness.
  const auto patch = [](double h) {
    return 4 * printed::van_der_waals({kHamaker}, kRough, h + kRough.roughness).force;
  };
  const auto parallel = [&](double h) { return van_der_waals(law, kRough, h); };
  rows.push_back(across_gaps("van_der_waals", "patch", annulus_integral, patch, patch));
  rows.push_back(across_gaps("van_der_waals", "annulus closed form", annulus_integral, parallel));
  const Real tilted = tilted_mean([&](double h) { return parallel(h).force; });
  for (const int order : {1, 2, 3, 5, 8, 16, 32})
    rows.push_back(tilted_quadrature(law, order, tilted));
  rows.push_back(
      tilted_closed_form("van_der_waals", TiltedAnnulus::of(&law, nullptr, kRough), 0, tilted));
}

void add_electrostatic(std::vector<LawRow>& rows) {
  const Electrostatic law = {kVoltage};
  const auto plates = [](double h) {
    return printed::electrostatic({kVoltage}, kRough, h + kRough.roughness).force;
  };
  rows.push_back(across_gaps("electrostatic", "patch", cylinders, plates, plates));
  rows.push_back(across_gaps("electrostatic", "exact cylinders", cylinders,
                             [&](double h) { return electrostatic(law, kRough, h); }));
  rows.push_back(tilted_closed_form("electrostatic", TiltedAnnulus::of(nullptr, &law, kRough), 1,
                                    tilted_mean(cylinders)));
}

// Maugis: depth to force at lambda = 4.
LawRow maugis_table() {
  const MaugisCurve curve(4);
  std::vector<double> depths;
  double error = 0;
  for (std::size_t i = 0; i < kPoints; ++i) {
    const MaugisPoint p = maugis_at_radius(4, 0.7 + 0.1 * static_cast<double>(i));
    depths.push_back(p.D);
    error = std::max(error, std::abs(curve.at(p.D, 1).P - p.P) / std::max(0.1, std::abs(p.P)));
  }
  return {"adhesion", "Maugis table, force slope energy radius",
          nanoseconds_per_call([&](long i) { keep(curve.at(one_of(depths, i), 1)); }), error};
}

}  // namespace

std::vector<LawRow> bench_laws(const GoOn& go_on) {
  Cases<LawRow> cases = {add_van_der_waals, add_electrostatic};
  add_case(cases, [] {
    return across_gaps("capillary", "bridge of constant volume", bridge,
                       [](double h) { return capillary(kBridge, kRough, h, true); });
  });
  add_case(cases, maugis_table);
  return rows_of(cases, go_on);
}

}  // namespace ferrule
