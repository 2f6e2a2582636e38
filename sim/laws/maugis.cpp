#include "sim/laws/maugis.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/base/elementary.hpp"
#include "sim/base/error.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kTableEnds = 1e4;  // in D; beyond, the equations are solved at each call
constexpr double kSmallestS = 1e-9, kLargestS = 1e9;
constexpr int kMostNewton = 12;

// s + (s^2 - 1) atan s. Its leading terms cancel for small s, where the series is used.
double ring_bending(double s) noexcept {
  if (s > 0.3) return s + (s * s - 1) * elementary::atan(s);
  double sum = 0, power = s * s * s;
  for (int k = 0; k < 18; ++k, power *= -s * s)
    sum += power * (1.0 / (2 * k + 1) + 1.0 / (2 * k + 3));
  return sum;
}

// s atan s - m + 1 with m - 1 = s^2/(1 + m).
double ring_opening(double s, double m) noexcept {
  return s * (elementary::atan(s) - s / (1 + m));
}

double m_of(double s) noexcept {
  return std::sqrt(1 + s * s);
}

// A root of f between a and b; where it does not change sign, the end that is nearer to one.
template <class F>
double root(const F& f, double a, double b) noexcept {
  if (a > b) std::swap(a, b);
  const double fa = f(a), fb = f(b);
  if (fa == 0 || fb == 0 || (fa > 0) == (fb > 0)) return std::abs(fa) < std::abs(fb) ? a : b;
  std::uintmax_t iterations = 200;
  const auto found = boost::math::tools::toms748_solve(
      f, a, b, fa, fb, boost::math::tools::eps_tolerance<double>(53), iterations);
  return 0.5 * (found.first + found.second);
}

// Integral of P dD = P 4 y^3 dy from a cell's begin, as a polynomial in the fraction u of the cell,
// y = width (cell + u).
template <std::size_t n>
std::array<double, n + 3> work(const std::array<double, n>& P, double width, double cell) noexcept {
  std::array<double, n + 3> gained{};
  const double scale = 4 * width * width * width * width;
  for (std::size_t k = 0; k < n; ++k) {
    const double d = static_cast<double>(k);
    gained[k] += scale * P[k] * cell * cell * cell / (d + 1);
    gained[k + 1] += scale * P[k] * 3 * cell * cell / (d + 2);
    gained[k + 2] += scale * P[k] * 3 * cell / (d + 3);
    gained[k + 3] += scale * P[k] / (d + 4);
  }
  return gained;
}

// The polynomial c at u, in two interleaved halves: even powers and odd ones.
template <std::size_t n>
double polynomial(const std::array<double, n>& c, double u) noexcept {
  static_assert(n >= 2);
  const double u2 = u * u;
  double even = 0, odd = 0;
  for (std::size_t k = (n - 1) / 2 * 2 + 2; k > 0; k -= 2) {
    even = even * u2 + c[k - 2];
    if (k - 1 < n) odd = odd * u2 + c[k - 1];
  }
  return even + u * odd;
}

template <std::size_t n>
double polynomial_slope(const std::array<double, n>& c, double u) noexcept {
  double slope = 0;
  for (std::size_t k = n - 1; k > 0; --k) slope = slope * u + static_cast<double>(k) * c[k];
  return slope;
}

}  // namespace

MaugisPoint maugis_at_s(double lambda, double s) noexcept {
  const double m = m_of(s);
  const double a = 0.5 * lambda * ring_bending(s);
  const double b = 4.0 / 3 * lambda * lambda * ring_opening(s, m);
  const double A = 2 / (b + std::sqrt(b * b + 4 * a));
  return {A, m, A * A * A - lambda * A * A * (s + m * m * elementary::atan(s)),
          A * A - 4.0 / 3 * lambda * A * s};
}

MaugisPoint maugis_at_radius(double lambda, double radius) noexcept {
  const auto closure = [&](double log_s) {
    const double s = elementary::exp(log_s);
    return 0.5 * lambda * radius * radius * ring_bending(s) +
           4.0 / 3 * lambda * lambda * radius * ring_opening(s, m_of(s)) - 1;
  };
  const double s =
      elementary::exp(root(closure, elementary::log(kSmallestS), elementary::log(kLargestS)));
  MaugisPoint p = maugis_at_s(lambda, s);
  // Of the given radius exactly; s is what the closure leaves to rounding.
  p.A = radius;
  p.P = radius * radius * radius - lambda * radius * radius * (s + p.m * p.m * elementary::atan(s));
  p.D = radius * radius - 4.0 / 3 * lambda * radius * s;
  return p;
}

MaugisPoint maugis_apart(double lambda, double disc) noexcept {
  return {0, kInfinity, -0.5 * pi * lambda * disc * disc,
          0.5 * disc * disc - 8 * lambda * disc / (3 * pi) - 2 / (pi * lambda)};
}

double maugis_touching_disc(double lambda) noexcept {
  const double b = lambda * (4.0 / 3 - 8 / (3 * pi)), c = 2 / (pi * lambda);
  return 2 * c / (b + std::sqrt(b * b + 2 * c));
}

namespace {

// A contact with its derivatives along the curve. The energy is that of the elastic bodies and the
// stress, less the work of adhesion on the disc of radius m A: where closure holds its differential
// is P dD.
struct TouchingPoint {
  MaugisPoint point;
  double D_by_s, slope, A_slope, energy;  // slopes: by D

  TouchingPoint(double lambda, double s) noexcept : point(maugis_at_s(lambda, s)) {
    const double A = point.A, m = point.m, m2 = m * m, angle = elementary::atan(s);
    const double b = ring_bending(s), o = ring_opening(s, m), g = s + m2 * angle;
    const double closure_A = lambda * (A * b + 4.0 / 3 * lambda * o);
    const double closure_s =
        lambda * A * (A * (s * angle + s * s / m2) + 4.0 / 3 * lambda * (angle + s / m2 - s / m));
    const double A_by_s = -closure_s / closure_A;
    D_by_s = (2 * A - 4.0 / 3 * lambda * s) * A_by_s - 4.0 / 3 * lambda * A;
    A_slope = A_by_s / D_by_s;
    slope = A * ((3 * A - 2 * lambda * g) * A_by_s - 2 * lambda * A * (1 + s * angle)) / D_by_s;
    energy = A * A *
             (A * A * (0.4 * A + lambda * (0.25 * m2 * b - 0.5 * g - s / 3)) +
              4.0 / 9 * lambda * lambda * A * (g * s + 2 * m2 * o) - m2);
  }
};

}  // namespace

double MaugisCurve::D_at(bool touching, double parameter) const noexcept {
  return touching ? maugis_at_s(lambda_, elementary::exp(parameter)).D
                  : maugis_apart(lambda_, parameter).D;
}

// Tabulates from parameter `from` (D = begin) to `to`, on which D grows.
MaugisCurve::Piece MaugisCurve::tabulate(bool touching, double from, double to,
                                         double begin) const {
  Piece piece;
  piece.begin = begin;
  const double end = D_at(touching, to);
  piece.end = end;
  if (touching) piece.energy_there = TouchingPoint(lambda_, elementary::exp(to)).energy;
  const double width = std::sqrt(std::sqrt(end - begin)) / static_cast<double>(kCells);
  piece.cells_per_y = 1 / width;

  // Polynomials through the values at Chebyshev-Lobatto nodes, so that cells meet exactly.
  Eigen::Matrix<double, kDegree + 1, kDegree + 1> powers;
  std::array<double, kDegree + 1> nodes;
  for (int i = 0; i <= kDegree; ++i) {
    nodes[static_cast<std::size_t>(i)] = 0.5 * (1 - elementary::cos(pi * i / kDegree));
    powers(i, 0) = 1;
    for (int k = 0; k < kDegree; ++k)
      powers(i, k + 1) = powers(i, k) * nodes[static_cast<std::size_t>(i)];
  }
  const auto solver = powers.fullPivLu();
  for (std::size_t cell = 0; cell < kCells; ++cell) {
    Eigen::Matrix<double, kDegree + 1, 1> force, radius;
    for (int i = 0; i <= kDegree; ++i) {
      const double y = width * (static_cast<double>(cell) + nodes[static_cast<std::size_t>(i)]);
      const double D = begin + y * y * y * y;
      double parameter = from;
      if (y > 0) parameter = root([&](double p) { return D_at(touching, p) - D; }, from, to);
      const MaugisPoint p = touching ? maugis_at_s(lambda_, elementary::exp(parameter))
                                     : maugis_apart(lambda_, parameter);
      force[i] = p.P;
      radius[i] = p.A;
    }
    const Eigen::Matrix<double, kDegree + 1, 1> f = solver.solve(force), r = solver.solve(radius);
    Cell& here = piece.cells.emplace_back();
    for (int k = 0; k <= kDegree; ++k) {
      here.force[static_cast<std::size_t>(k)] = f[k];
      here.radius[static_cast<std::size_t>(k)] = r[k];
    }
    here.energy = piece.energy;
    here.gained = work(here.force, width, static_cast<double>(cell));
    piece.energy += polynomial(here.gained, 1);
  }
  return piece;
}

// Beyond the table the equations are solved, by Newton's method in log D by log s.
MaugisCurve::Value MaugisCurve::beyond(const Piece& table, double D) const noexcept {
  double s = std::min(elementary::cbrt(1.5 / (lambda_ * D)),
                      std::sqrt(1.5 / (lambda_ * lambda_ * std::sqrt(D))));
  for (int n = 0; n < kMostNewton; ++n) {
    const TouchingPoint there(lambda_, s);
    const double step = -elementary::log(there.point.D / D) * there.point.D / (there.D_by_s * s);
    s *= elementary::exp(std::clamp(step, -1.0, 1.0));
    if (std::abs(step) < 1e-8) break;  // it converges quadratically
  }
  const TouchingPoint there(lambda_, s);
  Value value;
  value.P = there.point.P;
  value.A = there.point.A;
  value.slope = there.slope;
  value.A_slope = there.A_slope;
  value.energy = table.energy + there.energy - table.energy_there;
  return value;
}

inline MaugisCurve::Value MaugisCurve::on(const Branch& branch, double D) const noexcept {
  const Piece* piece = &branch.pieces.front();
  double before = 0;
  if (branch.pieces.size() > 1 && D >= branch.pieces[1].begin) {
    before = piece->energy;
    piece = &branch.pieces[1];
  }
  Value value;
  if (D > piece->end && !std::isfinite(branch.end)) {
    value = beyond(*piece, D);
    value.energy += before;
    return value;
  }
  const double y = std::sqrt(std::sqrt(std::max(0.0, D - piece->begin)));
  const double place = y * piece->cells_per_y;
  const auto number = std::min(static_cast<std::size_t>(place), kCells - 1);
  const double u = place - static_cast<double>(number);
  const Cell& cell = piece->cells[number];
  value.P = polynomial(cell.force, u);
  value.A = polynomial(cell.radius, u);
  // The slopes are infinite where a branch begins at a fold.
  const double y_slope = std::max(y, 1e-4);
  const double per_D = piece->cells_per_y / (4 * y_slope * y_slope * y_slope);
  value.slope = polynomial_slope(cell.force, u) * per_D;
  value.A_slope = polynomial_slope(cell.radius, u) * per_D;
  value.energy = before + cell.energy + u * polynomial(cell.gained, u);
  return value;
}

MaugisCurve::MaugisCurve(double lambda) : lambda_(lambda) {
  if (!(lambda >= 0.01 && lambda <= 100))
    throw BadInput("lambda = " + std::to_string(lambda) + ": must be from 0.01 to 100");
  attaches_ = -2 / (pi * lambda);

  // In contact: the smallest D, over log s. Where it is at the largest s, D grows from touch on.
  const double touch_s = elementary::log(kLargestS);
  const auto depth = [&](double log_s) { return D_at(true, log_s); };
  double lowest = touch_s;
  for (double log_s = elementary::log(1e4); log_s > elementary::log(1e-3); log_s -= 0.02)
    if (depth(log_s) < depth(lowest)) lowest = log_s;
  const bool folds = lowest < elementary::log(9e3);
  if (folds)
    lowest = boost::math::tools::brent_find_minima(depth, lowest - 0.03, lowest + 0.03, 52).first;
  else
    lowest = touch_s;
  double end_s = lowest;  // where the table ends
  while (depth(end_s) < kTableEnds) end_s -= 0.1;

  const double fold_disc = 8 * lambda / (3 * pi), touch_disc = maugis_touching_disc(lambda);
  if (touch_disc > fold_disc) {
    Branch& near = stable_[count_++];
    const double begin = maugis_apart(lambda, fold_disc).D;
    near.pieces.push_back(tabulate(false, fold_disc, touch_disc, begin));
    near.begin = begin;
    near.end = near.pieces.back().end;
  }
  if (folds || count_ == 0) ++count_;
  Branch& contact = stable_[count_ - 1];
  const double begin = folds ? depth(lowest) : maugis_apart(lambda, touch_disc).D;
  if (contact.pieces.empty()) contact.begin = begin;
  contact.pieces.push_back(tabulate(true, lowest, end_s, begin));
  contact.end = kInfinity;
  for (std::size_t b = 0; b < count_; ++b) {
    stable_[b].energy_at_end =
        std::isfinite(stable_[b].end) ? on(stable_[b], stable_[b].end).energy : 0;
    for (const Piece& piece : stable_[b].pieces)
      for (std::size_t i = 0; i < piece.cells.size(); ++i) {
        if (piece.cells[i].force[0] > pull_off_) continue;
        // The least is within the cell of the least node or the one before.
        for (const std::size_t j : {i, i - (i > 0 ? 1u : 0u)})
          pull_off_ = std::min(
              pull_off_,
              boost::math::tools::brent_find_minima(
                  [&](double u) { return polynomial(piece.cells[j].force, u); }, 0.0, 1.0, 40)
                  .second);
      }
  }
}

MaugisCurve::Value MaugisCurve::at(double D, int branch) const noexcept {
  if (branch == 0 || D < begins(branch) || D >= ends(branch)) return jump(D, branch);
  Value value = on(stable_[static_cast<std::size_t>(branch - 1)], D);
  value.branch = branch;
  return value;
}

// At D, which may not be on `branch`.
MaugisCurve::Value MaugisCurve::jump(double D, int branch) const noexcept {
  double jumped = 0;  // energy up to the last jump, less that of the branch jumped to
  const auto energy_on = [&](int b, double d) {
    return b == 0 ? 0.0 : on(stable_[static_cast<std::size_t>(b - 1)], d).energy;
  };
  const auto holds = [&](int b, double d) { return begins(b) <= d && d < ends(b); };
  for (int jumps = 0; jumps < 4; ++jumps) {
    int next = branch;
    double where = 0;
    if (branch == 0) {
      if (D >= attaches_) {
        where = attaches_;
        next = holds(1, where) ? 1 : branches();
      }
    } else if (D < begins(branch)) {
      where = begins(branch);
      next = branch == 2 && holds(1, where) ? 1 : 0;
    } else if (D >= ends(branch)) {
      where = ends(branch);
      next = branch + 1;
    }
    if (next == branch) break;
    jumped += energy_on(branch, where) - energy_on(next, where);
    branch = next;
  }
  Value value;
  if (branch > 0) value = on(stable_[static_cast<std::size_t>(branch - 1)], D);
  value.energy += jumped;
  value.branch = branch;
  return value;
}

std::vector<MaugisPoint> MaugisCurve::points(std::size_t count) const {
  std::vector<MaugisPoint> all;
  const double touch = maugis_touching_disc(lambda_);
  const std::size_t apart = count / 3;
  for (std::size_t i = 0; i < apart; ++i)
    all.push_back(
        maugis_apart(lambda_, touch * static_cast<double>(i) / static_cast<double>(apart)));
  const double first = elementary::log(1e4);
  double last = 0;
  while (D_at(true, last) < 6) last -= 0.1;
  while (D_at(true, last) > 6) last += 0.02;
  const std::size_t rest = count - all.size();
  for (std::size_t i = 0; i < rest; ++i)
    all.push_back(
        maugis_at_s(lambda_, elementary::exp(first + (last - first) * static_cast<double>(i) /
                                                         static_cast<double>(rest - 1))));
  return all;
}

}  // namespace ferrule
