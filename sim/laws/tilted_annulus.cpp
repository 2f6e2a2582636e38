#include "sim/laws/tilted_annulus.hpp"

#include <cmath>
#include <numbers>

#include "sim/base/elementary.hpp"

namespace ferrule {
namespace {

// A function of u, v and d, with its derivatives.
struct OfEnds {
  double value = 0, u = 0, v = 0, d = 0;
  double uu = 0, uv = 0, vv = 0, ud = 0, vd = 0, dd = 0;
};

// The ends' u, v and d with what both means take from them.
struct Ends {
  double u, v, d;
  double iu = 1 / u, iv = 1 / v;
  double sum = u + v, W = 1 / (sum * sum + d);
};

// 2 (1/u + 1/v) W, W = 1/((u + v)^2 + d), times `factor`.
OfEnds cubed_mean(double factor, const Ends& ends) noexcept {
  const double iu = ends.iu, iv = ends.iv, sum = ends.sum, s = iu + iv;
  const double W1 = factor * ends.W, W2 = W1 * ends.W, W3 = W2 * ends.W;
  const double common = sum * s * W2, steep = 16 * sum * sum * s * W3 - 4 * s * W2;
  const double turn = 8 * sum * s * W3;
  OfEnds f;
  f.value = 2 * s * W1;
  f.d = -2 * s * W2;
  f.dd = 4 * s * W3;
  f.u = -2 * iu * iu * W1 - 4 * common;
  f.v = -2 * iv * iv * W1 - 4 * common;
  f.ud = 2 * iu * iu * W2 + turn;
  f.vd = 2 * iv * iv * W2 + turn;
  f.uu = 4 * iu * iu * iu * W1 + 8 * sum * iu * iu * W2 + steep;
  f.vv = 4 * iv * iv * iv * W1 + 8 * sum * iv * iv * W2 + steep;
  f.uv = 4 * sum * (iu * iu + iv * iv) * W2 + steep;
  return f;
}

// atan(z)/z as a function of t = z^2, with two derivatives; open = 1/(1 + t).
struct Arc {
  double value, first, second;
};
Arc arc(double z, double open) noexcept {
  const double t = z * z;
  if (t < 0.02) {
    constexpr std::array<double, 10> c = {1.0,       -1.0 / 3, 1.0 / 5,   -1.0 / 7, 1.0 / 9,
                                          -1.0 / 11, 1.0 / 13, -1.0 / 15, 1.0 / 17, -1.0 / 19};
    Arc sum{0, 0, 0};
    for (auto k = c.rbegin(); k != c.rend(); ++k) {
      sum.second = sum.second * t + 2 * sum.first;
      sum.first = sum.first * t + sum.value;
      sum.value = sum.value * t + *k;
    }
    return sum;
  }
  const double per_z = 1 / z, half = 0.5 * per_z * per_z;
  const double value = elementary::atan(z) * per_z;
  const double first = (open - value) * half;
  return {value, first, -(open * open + 3 * first) * half};
}

// 2 arc(d/(u + v)^2)/(u + v), times `factor`. Its derivative by u + v is -2 open/(u + v)^2.
OfEnds single_mean(double factor, const Ends& ends) noexcept {
  const double i = 1 / ends.sum, i2 = i * i, open = ends.sum * ends.sum * ends.W;
  const Arc A = arc(std::sqrt(ends.d) * i, open);
  const double f1 = 2 * factor * i, f2 = f1 * i, f3 = f2 * i;
  OfEnds f;
  f.value = f1 * A.value;
  f.u = f.v = -f2 * open;
  f.uu = f.uv = f.vv = 2 * f3 * open * open;
  f.d = f3 * A.first;
  f.ud = f.vd = f3 * i * open * open;
  f.dd = f3 * i2 * A.second;
  return f;
}

}  // namespace

TiltedAnnulus TiltedAnnulus::of(const VanDerWaals* van_der_waals,
                                const Electrostatic* electrostatic,
                                const Annulus& annulus) noexcept {
  TiltedAnnulus law;
  law.clearance = annulus.clearance() + annulus.roughness;
  const double r = annulus.fibre_radius;
  if (van_der_waals) law.cubed = van_der_waals->hamaker * r * law.clearance / 6;
  if (electrostatic)
    law.single = std::numbers::pi * kPermittivity * electrostatic->voltage *
                 electrostatic->voltage * std::sqrt(r * (r + law.clearance));
  return law;
}

LineMean line_mean(const TiltedAnnulus& law, const Vector2d& e_a, const Vector2d& e_b) noexcept {
  const double C2 = law.clearance * law.clearance;
  const Vector2d apart = e_b - e_a;
  const Ends ends{std::sqrt(C2 - e_a.squaredNorm()), std::sqrt(C2 - e_b.squaredNorm()),
                  apart.squaredNorm()};
  const double iu = ends.iu, iv = ends.iv;

  LineMean mean;
  OfEnds sum;
  const auto add = [&](std::size_t which, const OfEnds& f) {
    mean.value[which] = f.value;
    mean.by_a[which] = -f.u * iu * e_a - 2 * f.d * apart;
    mean.by_b[which] = -f.v * iv * e_b + 2 * f.d * apart;
    sum.u += f.u;
    sum.v += f.v;
    sum.d += f.d;
    sum.uu += f.uu;
    sum.uv += f.uv;
    sum.vv += f.vv;
    sum.ud += f.ud;
    sum.vd += f.vd;
    sum.dd += f.dd;
  };
  if (law.cubed != 0) add(0, cubed_mean(-law.cubed, ends));
  if (law.single != 0) add(1, single_mean(-law.single, ends));

  // Chain rule: du/de_a = -e_a/u, d(du/de_a)/de_a = -(1 + e_a e_a/u^2)/u, and so on.
  const double fu = sum.u * iu, fv = sum.v * iv;
  const double along_a = (sum.uu - fu) * iu * iu, along_b = (sum.vv - fv) * iv * iv;
  const double turn_a = 2 * sum.ud * iu, turn_b = 2 * sum.vd * iv, both = sum.uv * iu * iv;
  const double two = 2 * sum.d;
  const Vector2d steep = 4 * sum.dd * apart;
  const Vector2d a_by_a = along_a * e_a + turn_a * apart, apart_by_a = turn_a * e_a + steep;
  const Vector2d b_by_b = along_b * e_b - turn_b * apart, apart_by_b = turn_b * e_b - steep;
  const Vector2d a_by_b = both * e_b - turn_a * apart;
  mean.aa = (two - fu) * kIdentity + e_a * a_by_a.transpose() + apart * apart_by_a.transpose();
  mean.bb = (two - fv) * kIdentity + e_b * b_by_b.transpose() - apart * apart_by_b.transpose();
  mean.ab = e_a * a_by_b.transpose() + apart * apart_by_b.transpose() - two * kIdentity;
  mean.ba = a_by_b * e_a.transpose() + apart_by_b * apart.transpose() - two * kIdentity;
  return mean;
}

double closed_form_error(const Annulus& annulus) noexcept {
  const double C = annulus.clearance() + annulus.roughness, r = annulus.fibre_radius;
  return C * C / (24 * r * (r + C));
}

}  // namespace ferrule
