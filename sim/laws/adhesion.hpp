// Adhesion at a closed contact, (6c): Maugis-Dugdale, self-consistent (sim/laws/maugis.hpp),
// attraction and elastic resistance together, with the branch that holds as state. No further wall
// is needed. And the reduced modulus, (7) of the paper.
#pragma once

#include <memory>

#include "sim/laws/maugis.hpp"

namespace ferrule {

// 1/K = (3/4) ((1 - nu_o^2)/E_o + (1 - nu_f^2)/E_f), equation (7). Moduli [Pa]; returns K [Pa].
double reduced_modulus(double young_fibre, double poisson_fibre, double young_ferrule,
                       double poisson_ferrule) noexcept;

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
  double work_of_adhesion;  // w = 2 gamma_L [J/m^2], > 0: the work, not the surface energy gamma
  double maugis_lambda;     // lambda [-], 0.01 to 100
  double reduced_modulus;   // K [Pa], > 0
  double radius;            // R_s [m], > 0: the fibre's unless stated
  // Of the values above, by prepare(). Shared by the copies of a world.
  std::shared_ptr<const MaugisContact> contact = nullptr;
};

// Throws BadInput if lambda is out of range.
Adhesion prepare(Adhesion law);

// A force at one contact against the penetration d; repulsion is positive.
//   force = d potential / dd,   slope = d force / dd
struct ContactForce {
  double potential = 0;  // [J]
  double force = 0;      // [N]
  double slope = 0;      // [N/m]
};

struct AdhesionForce : ContactForce {
  double radius = 0;        // contact radius a [m]; 0 where the surfaces do not touch
  double radius_slope = 0;  // d radius / dd [-]
  int branch = 0;           // that holds at this depth
};

// At penetration `depth` [m], any finite value, coming from `branch`. The law is prepared.
AdhesionForce adhesion(const Adhesion& law, double depth, int branch = 0) noexcept;

}  // namespace ferrule
