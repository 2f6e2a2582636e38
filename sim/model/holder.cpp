#include "sim/model/holder.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace ferrule {
namespace {

using std::numbers::pi;

double euler(double bending_stiffness, double length) noexcept {
  return 0.25 * pi * pi * bending_stiffness / (length * length);
}

double second_moment(double radius) noexcept {
  return 0.25 * pi * radius * radius * radius * radius;
}

void finish(Holder& holder) {
  holder.sag = holder.stiffness.llt().solve(holder.weight);
  holder.tilt_length = std::sqrt(holder.stiffness(3, 3) / holder.stiffness(1, 1));
}

}  // namespace

double Holder::bending_stress(const Pose& tip, const Pose& command) const noexcept {
  if (free_length == 0) return 0;
  const Eigen::Vector4d across =
      stiffness.bottomRightCorner<4, 4>() * (tip - command).tail<4>();  // no part of it along x
  // Moments at the end, without its share of the weight, and along the free length at the gripper.
  const Vector2d at_end = across.tail<2>() - weight.tail<2>();
  const Vector2d at_gripper = at_end - free_length * across.head<2>();
  const double moment = std::sqrt(std::max(at_end.squaredNorm(), at_gripper.squaredNorm()));
  return moment * fibre_radius / second_moment(fibre_radius);
}

double Holder::work_of_hand(const Pose& tip, const Pose& from, const Pose& to) const noexcept {
  const Pose deflection = tip - 0.5 * (from + to);
  return -(stiffness * deflection).dot(to - from);
}

// The lower root of det(K - omega^2 M) in y and its tilt.
double Holder::bending_frequency() const noexcept {
  Matrix2d k, m;
  k << stiffness(1, 1), stiffness(1, 3), stiffness(3, 1), stiffness(3, 3);
  m << mass(1, 1), mass(1, 3), mass(3, 1), mass(3, 3);
  const double a = m.determinant(), c = k.determinant();
  const double b = k(0, 0) * m(1, 1) + k(1, 1) * m(0, 0) - 2 * k(0, 1) * m(0, 1);
  return std::sqrt(2 * c / (b + std::sqrt(b * b - 4 * a * c)));
}

double Holder::compliance() const noexcept {
  return Matrix5(stiffness.inverse()).topLeftCorner<3, 3>().norm();
}

Holder rigid_hand(double stiffness, double tilt_stiffness, const FibreMass& fibre, double young,
                  const GravityLaw& gravity) {
  Holder holder;
  holder.stiffness.diagonal() << Vector3d::Constant(stiffness), Vector2d::Constant(tilt_stiffness);
  if (present(gravity)) holder.weight[1] = -weight(gravity, fibre);
  const double mass = fibre.mass();
  holder.mass.diagonal() << Vector3d::Constant(mass),
      Vector2d::Constant(mass * fibre.length * fibre.length / 3);
  holder.euler_load = euler(young * second_moment(fibre.radius), fibre.length);
  finish(holder);
  return holder;
}

Holder elastic_fibre(double free_length, double gripper_stiffness, const FibreMass& fibre,
                     double young, const GravityLaw& gravity, double loss_factor) {
  Holder holder;
  const double L = free_length, r = fibre.radius;
  const double EI = young * second_moment(r);
  const double axial = young * pi * r * r / L;
  holder.stiffness(0, 0) = axial * gripper_stiffness / (axial + gripper_stiffness);
  const FibreMass free = {r, fibre.density, L};
  const double mass = free.mass();
  holder.mass(0, 0) = mass / 3;
  for (const int y : {1, 2}) {
    const int tilt = y + 2;
    const double k = EI / (L * L * L), m = mass / 420;
    holder.stiffness(y, y) = 12 * k;
    holder.stiffness(y, tilt) = holder.stiffness(tilt, y) = 6 * k * L;
    holder.stiffness(tilt, tilt) = 4 * k * L * L;
    holder.mass(y, y) = 156 * m;
    holder.mass(y, tilt) = holder.mass(tilt, y) = 22 * m * L;
    holder.mass(tilt, tilt) = 4 * m * L * L;
  }
  if (present(gravity)) {
    const double load = weight(gravity, free);
    holder.weight[1] = -0.5 * load;
    holder.weight[3] = -load * L / 12;
    holder.weight_arm.x() = L / 6;
  }
  holder.free_length = L;
  holder.fibre_radius = r;
  holder.euler_load = euler(EI, L);
  holder.damping.bottomRightCorner<4, 4>() =
      loss_factor / holder.bending_frequency() * holder.stiffness.bottomRightCorner<4, 4>();
  finish(holder);
  return holder;
}

}  // namespace ferrule
