// Adhesion at a closed contact, equation (6) of the paper (Maugis-Dugdale), and the reduced
// modulus, equation (7).
//
// Printed, (6):
//     F = K a^3 / r - lambda a^2 (pi w K^2 / r)^(1/3) (s + m^2 atan s),   s = sqrt(m^2 - 1)
//   with the contact radius prescribed: a = 100 nm + 2 d for a penetration 0 <= d <= 10 nm, held at
//   120 nm beyond. As printed it attracts ever more with depth (E7 in sim/README.md), so the wall
//   (sim/laws/wall.hpp) begins where the prescription ends. The force jumps at d = 0; it is reached
//   in a straight line over the last a_0 = 0.1 nm of the approach, -a_0 < d < 0.
// Corrected, (6c): self-consistent (sim/laws/maugis.hpp), attraction and elastic resistance
//   together, with the branch that holds as state. No further wall is needed.
#pragma once

#include <memory>

#include "sim/laws/form.hpp"
#include "sim/laws/maugis.hpp"

namespace ferrule {

// 1/K = (3/4) ((1 - nu_o^2)/E_o + (1 - nu_f^2)/E_f), equation (7). Moduli [Pa]; returns K [Pa].
double reduced_modulus(double young_fibre, double poisson_fibre, double young_ferrule,
                       double poisson_ferrule) noexcept;

// Prescribed contact radius a [m] of the printed form at penetration d [m].
double printed_contact_radius(double depth) noexcept;

// Largest penetration the printed form speaks of [m]: 10 nm.
inline constexpr double kPrintedDepth = 10e-9;

// The curve of (6c) with its scales: F = force P, delta = depth D, a = contact A.
struct MaugisContact {
  // lambda as for MaugisCurve; w [J/m^2], K [Pa], R_s [m], all > 0.
  MaugisContact(double lambda, double work_of_adhesion, double reduced_modulus, double radius);

  MaugisCurve curve;
  double force;   // pi w R_s [N]
  double depth;   // (pi^2 w^2 R_s/K^2)^(1/3) [m]
  double radius;  // (pi w R_s^2/K)^(1/3) [m]
};

struct Adhesion {
  Form form;
  double work_of_adhesion;  // w = 2 gamma_L [J/m^2], > 0: the work, not the surface energy gamma
  double maugis_lambda;     // lambda [-]; printed 0.12 to 5.8, corrected 0.01 to 100
  double m;                 // c_ad / a [-], >= 1; printed form only
  double reduced_modulus;   // K [Pa], > 0
  double radius;            // r in (6), R_s in (6c) [m], > 0: the fibre radius unless stated
  // Of the values above; corrected form only. Shared by the copies of a world.
  std::shared_ptr<const MaugisContact> contact = nullptr;
};

// A force at one contact against the penetration d; repulsion is positive.
//   force = d potential / dd,   slope = d force / dd
struct ContactForce {
  double potential = 0;  // [J]
  double force = 0;      // [N]
  double slope = 0;      // [N/m]
};

struct AdhesionForce : ContactForce {
  double radius = 0;  // contact radius a [m]; 0 where the surfaces do not touch
  int branch = 0;     // that holds at this depth; always 0 in the printed form
};

// At penetration `depth` [m], any finite value, coming from `branch`.
AdhesionForce adhesion(const Adhesion& law, double depth, int branch = 0) noexcept;

}  // namespace ferrule
