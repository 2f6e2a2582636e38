#include "sim/tilted_annulus.hpp"

#include <cmath>
#include <numbers>

namespace ferrule {
namespace {

// A function of u, v and d, with its derivatives.
struct OfEnds {
  double value = 0, u = 0, v = 0, d = 0;
  double uu = 0, uv = 0, vv = 0, ud = 0, vd = 0, dd = 0;
};

// 2 (1/u + 1/v) W, W = 1/((u + v)^2 + d), times `factor`.
OfEnds cubed_mean(double factor, double u, double v, double d) noexcept {
  const double sum = u + v, p = 1 / (u * v), W = 1 / (sum * sum + d);
  const double iu = v * p, iv = u * p, s = sum * p;
  const double W1 = factor * W, W2 = W1 * W, W3 = W2 * W;
  const double common = sum * s * W2, steep = 16 * sum * sum * s * W3 - 4 * s * W2;
  OfEnds f;
  f.value = 2 * s * W1;
  f.d = -2 * s * W2;
  f.dd = 4 * s * W3;
  f.u = -2 * iu * iu * W1 - 4 * common;
  f.v = -2 * iv * iv * W1 - 4 * common;
  f.ud = 2 * iu * iu * W2 + 8 * sum * s * W3;
  f.vd = 2 * iv * iv * W2 + 8 * sum * s * W3;
  f.uu = 4 * iu * iu * iu * W1 + 8 * sum * iu * iu * W2 + steep;
  f.vv = 4 * iv * iv * iv * W1 + 8 * sum * iv * iv * W2 + steep;
  f.uv = 4 * sum * (iu * iu + iv * iv) * W2 + steep;
  return f;
}

// atan(z)/z as a function of t = z^2, with two derivatives; open = 1/(1 + t).
struct Arc {
  double value, first, second;
};
Arc arc(double t, double open) noexcept {
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
  const double z = std::sqrt(t), half = 0.5 / t;
  const double value = std::atan(z) / z;
  const double first = (open - value) * half;
  return {value, first, -(open * open + 3 * first) * half};
}

// 2 arc(d/(u + v)^2)/(u + v), times `factor`. Its derivative by u + v is -2 open/(u + v)^2.
OfEnds single_mean(double factor, double u, double v, double d) noexcept {
  const double i = 1 / (u + v), i2 = i * i, t = d * i2, open = 1 / (1 + t);
  const Arc A = arc(t, open);
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
  const double u = std::sqrt(C2 - e_a.squaredNorm()), v = std::sqrt(C2 - e_b.squaredNorm());
  const Vector2d apart = e_b - e_a;
  const double d = apart.squaredNorm();
  const double iu = 1 / u, iv = 1 / v;

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
  if (law.cubed != 0) add(0, cubed_mean(-law.cubed, u, v, d));
  if (law.single != 0) add(1, single_mean(-law.single, u, v, d));

  // Chain rule: du/de_a = -e_a/u, d(du/de_a)/de_a = -(1 + e_a e_a/u^2)/u, and so on.
  const double fu = sum.u * iu, fv = sum.v * iv;
  const double along_a = (sum.uu - fu) * iu * iu, along_b = (sum.vv - fv) * iv * iv;
  const double turn_a = 2 * sum.ud * iu, turn_b = 2 * sum.vd * iv, both = sum.uv * iu * iv;
  const double ax = e_a.x(), ay = e_a.y(), bx = e_b.x(), by = e_b.y();
  const double dx = apart.x(), dy = apart.y(), two = 2 * sum.d;
  const double dxx = 4 * sum.dd * dx * dx, dxy = 4 * sum.dd * dx * dy, dyy = 4 * sum.dd * dy * dy;
  const double aa_xy = along_a * ax * ay + turn_a * (ax * dy + dx * ay) + dxy;
  const double bb_xy = along_b * bx * by - turn_b * (bx * dy + dx * by) + dxy;
  mean.aa << along_a * ax * ax + 2 * turn_a * ax * dx + dxx + two - fu, aa_xy, aa_xy,
      along_a * ay * ay + 2 * turn_a * ay * dy + dyy + two - fu;
  mean.bb << along_b * bx * bx - 2 * turn_b * bx * dx + dxx + two - fv, bb_xy, bb_xy,
      along_b * by * by - 2 * turn_b * by * dy + dyy + two - fv;
  mean.ab << both * ax * bx - turn_a * ax * dx + turn_b * dx * bx - dxx - two,
      both * ax * by - turn_a * ax * dy + turn_b * dx * by - dxy,
      both * ay * bx - turn_a * ay * dx + turn_b * dy * bx - dxy,
      both * ay * by - turn_a * ay * dy + turn_b * dy * by - dyy - two;
  return mean;
}

double closed_form_error(const Annulus& annulus) noexcept {
  const double C = annulus.clearance() + annulus.roughness, r = annulus.fibre_radius;
  return C * C / (24 * r * (r + C));
}

}  // namespace ferrule
