// The pose of the fibre's end, and vectors and matrices over it.
//
// The inserted end is a rigid rod with five degrees of freedom (roll does not matter):
//   pose = (x, y, z, tilt_y, tilt_z)
// with the centre of the end face at (x, y, z) [m] and the axis running from there towards the
// holder through (x + s, y + s tilt_y, z + s tilt_z); tilts are small slopes [rad]. Frame: x out of
// the bore, y up, z to the viewer; insertion is motion along -x; gravity is -y.
// The wrench conjugate to it is (F_x, F_y, F_z [N], M_y, M_z [N m]), with M_y the moment that
// raises tilt_y and M_z the one that raises tilt_z.
#pragma once

#include <Eigen/Core>
#include <cmath>

namespace ferrule {

using Pose = Eigen::Matrix<double, 5, 1>;
using Wrench = Eigen::Matrix<double, 5, 1>;
using Matrix5 = Eigen::Matrix<double, 5, 5>;
using Eigen::Matrix2d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// In memory: adding to a diagonal entry by entry would leave columns that were written in halves,
// and a processor forwards from store to load at once only what it reads in the blocks it was
// written in.
inline const Matrix2d kIdentity = Matrix2d::Identity();

// A vector of five in the blocks of a pose: x, across e = (y, z), tilts t.
struct PoseVector {
  Vector2d e = Vector2d::Zero();
  double x = 0;  // between them: full() would else read the end of e and the begin of t as one
  Vector2d t = Vector2d::Zero();

  PoseVector() = default;
  PoseVector(double x_, const Vector2d& e_, const Vector2d& t_) noexcept : e(e_), x(x_), t(t_) {}
  PoseVector(const Pose& p) noexcept {
    const Vector2d first = p.head<2>(), second = p.segment<2>(2);
    x = first[0];
    e = {first[1], second[0]};
    t = {second[1], p[4]};
  }

  Pose full() const noexcept {
    Pose p;
    p.head<2>() = Vector2d(x, e[0]);
    p.segment<2>(2) = Vector2d(e[1], t[0]);
    p[4] = t[1];
    return p;
  }
  PoseVector& operator+=(const PoseVector& p) noexcept {
    x += p.x;
    e += p.e;
    t += p.t;
    return *this;
  }
  PoseVector& operator-=(const PoseVector& p) noexcept {
    x -= p.x;
    e -= p.e;
    t -= p.t;
    return *this;
  }
  friend PoseVector operator*(double factor, const PoseVector& p) noexcept {
    return {factor * p.x, factor * p.e, factor * p.t};
  }
  friend PoseVector operator-(PoseVector p, const PoseVector& q) noexcept { return p -= q; }
  double dot(const PoseVector& other) const noexcept {
    return x * other.x + e.dot(other.e) + t.dot(other.t);
  }
  Vector3d position() const noexcept { return {x, e.x(), e.y()}; }
  // Length of its first three components: of a force or a move of the end.
  double length() const noexcept { return std::sqrt(x * x + e.squaredNorm()); }
};

// A symmetric 5x5 matrix in the blocks of a pose: x, across e = (y, z), tilts t.
struct PoseMatrix {
  double xx = 0;
  Vector2d xe = Vector2d::Zero(), xt = Vector2d::Zero();
  Matrix2d ee = Matrix2d::Zero(), et = Matrix2d::Zero(), tt = Matrix2d::Zero();

  PoseMatrix() = default;
  explicit PoseMatrix(const Matrix5& m) noexcept
      : xx(m(0, 0)),
        xe(m.block<1, 2>(0, 1).transpose()),
        xt(m.block<1, 2>(0, 3).transpose()),
        ee(m.block<2, 2>(1, 1)),
        et(m.block<2, 2>(1, 3)),
        tt(m.block<2, 2>(3, 3)) {}

  PoseMatrix& operator+=(const PoseMatrix& m) noexcept {
    xx += m.xx;
    xe += m.xe;
    xt += m.xt;
    ee += m.ee;
    et += m.et;
    tt += m.tt;
    return *this;
  }
  friend PoseMatrix operator*(double factor, PoseMatrix m) noexcept {
    m.xx *= factor;
    m.xe *= factor;
    m.xt *= factor;
    m.ee *= factor;
    m.et *= factor;
    m.tt *= factor;
    return m;
  }
  Matrix5 full() const noexcept {
    Matrix5 m;
    m << xx, xe.transpose(), xt.transpose(), xe, ee, et, xt, et.transpose(), tt;
    return m;
  }
  PoseVector times(const PoseVector& p) const noexcept {
    return {xx * p.x + xe.dot(p.e) + xt.dot(p.t), p.x * xe + ee * p.e + et * p.t,
            p.x * xt + et.transpose() * p.e + tt * p.t};
  }
};

}  // namespace ferrule
