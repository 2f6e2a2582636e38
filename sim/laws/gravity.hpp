// Weight of the manipulated length of fibre, (3c): F = rho pi r^2 l_b g, g = 9.80665 m/s^2.
#pragma once

#include <numbers>

namespace ferrule {

inline constexpr double kStandardGravity = 9.80665;  // [m/s^2]

// The part of the fibre that the weight belongs to.
struct FibreMass {
  double radius;   // r [m], > 0
  double density;  // rho [kg/m^3], > 0
  double length;   // l_b [m], > 0

  double mass() const noexcept {  // [kg]
    return density * std::numbers::pi * radius * radius * length;
  }
};

struct Gravity {};

// Magnitude of the force along -y [N], > 0.
inline double gravity(const Gravity&, const FibreMass& fibre) noexcept {
  return fibre.mass() * kStandardGravity;
}

}  // namespace ferrule
