// Friction of a single-asperity contact, equations (8) to (10) of the paper (Hurtado and Kim 1999,
// as given by Adams, Muftu and Azhar 2003).
//
// With a' = a/b, G* = 2 G_1 G_2/(G_1 + G_2):
//   F / (G* b^2) = tau_1 a'^2        a' < a_1
//                = 10^B a'^(M + 2)   a_1 <= a' <= a_2
//                = tau_2 a'^2        a' > a_2
//   M = -log(tau_1/tau_2)/log(a_2/a_1)
//   B = (log tau_1 log a_2 - log tau_2 log a_1)/log(a_2/a_1)           (log to base 10)
//   a_1 = 50, a_2 = 1e5, tau_1 = 0.02, tau_2 = 8e-4; continuous at both knees.
//
// The paper gives a magnitude. A simulator needs a direction and a stuck state: below that
// magnitude the contact is stuck and pulls its material point back to where it stuck with the
// tangential stiffness k_t = 8 G* a (Mindlin 1949, to order one); at that magnitude it slips, and
// the stuck point follows at the distance F / k_t. A held load therefore does not creep at all; the
// error of the regularisation is a displacement, at most F / k_t, some 0.1 nm with Table I.
#pragma once

namespace ferrule {

struct Friction {
  double shear_fibre;    // G_1 [Pa], > 0
  double shear_ferrule;  // G_2 [Pa], > 0
  double burgers;        // b [m], > 0

  double effective_shear_modulus() const noexcept {
    return 2 * shear_fibre * shear_ferrule / (shear_fibre + shear_ferrule);
  }
};

// Exponents M and B of (9) and (10).
double hurtado_kim_m() noexcept;
double hurtado_kim_b() noexcept;

// Largest friction force [N], >= 0, of a contact of radius a [m], a >= 0.
double friction(const Friction& law, double contact_radius) noexcept;

// d log F / d log a there: 2, M + 2 between the knees, and 2.
double friction_exponent(const Friction& law, double contact_radius) noexcept;

// Tangential stiffness k_t [N/m] of a stuck contact of radius a [m].
double sticking_stiffness(const Friction& law, double contact_radius) noexcept;

}  // namespace ferrule
