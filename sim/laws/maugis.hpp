// Adhesive contact of a sphere on a half space, self-consistent: Maugis 1992 (Dugdale stress in a
// ring around the contact), from DMT (lambda -> 0) to JKR (lambda -> infinity). Equation (6c) of
// docs/theory.md. Dimensionless:
//
//   A = a (K/(pi w R_s^2))^(1/3),  P = F/(pi w R_s),  D = delta (K^2/(pi^2 w^2 R_s))^(1/3)
//   a contact radius, F force (repulsion positive), delta penetration (negative: apart), K reduced
//   modulus (sim/laws/adhesion.hpp), w work of adhesion, R_s sphere radius, m = c_ad/a >= 1.
//
// In contact, with s = sqrt(m^2 - 1), closure gives A for each m (quadratic), and P and D follow:
//   (lambda A^2/2) [s + (m^2 - 2) atan s] + (4 lambda^2 A/3) [s atan s - m + 1] = 1
//   P = A^3 - lambda A^2 [s + m^2 atan s]
//   D = A^2 - (4/3) lambda A s
// Before contact the stress acts on a disc of radius C (same scale as A), 0 <= C <= C_touch:
//   D = C^2/2 - 8 lambda C/(3 pi) - 2/(pi lambda),   P = -(pi/2) lambda C^2
// which meets the former at A = 0, and begins at the range of the stress, D = -2/(pi lambda).
//
// P(D) folds. Where D is given, the parts of the curve on which D grows are stable: branches.
// Branch 0 is apart (P = 0); a branch that ends on the way in or out is left for the next one, and
// the energy between them is lost. Which branch holds is state, passed in and returned.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace ferrule {

struct MaugisPoint {
  double A, m, P, D;  // m is infinite where the surfaces do not touch (A = 0)
};

// The contact of given s = sqrt(m^2 - 1), s > 0. lambda > 0.
MaugisPoint maugis_at_s(double lambda, double s) noexcept;
// The contact of given radius A > 0.
MaugisPoint maugis_at_radius(double lambda, double radius) noexcept;
// Before contact: the stress on a disc of radius C >= 0.
MaugisPoint maugis_apart(double lambda, double disc) noexcept;
// C at which the surfaces touch.
double maugis_touching_disc(double lambda) noexcept;

// P(D) of one lambda with its branches, tabulated so that a look-up takes some ten nanoseconds.
class MaugisCurve {
 public:
  // 0.01 <= lambda <= 100; throws BadInput otherwise.
  explicit MaugisCurve(double lambda);

  struct Value {
    double P = 0;        // force
    double slope = 0;    // dP/dD
    double energy = 0;   // integral of P dD along the way, from branch `branch` at the start
    double A = 0;        // contact radius
    double A_slope = 0;  // dA/dD
    int branch = 0;      // that holds at D
  };
  // At D, coming from branch `branch`. Force relative error below 1e-8 (see bench). Any finite D.
  Value at(double D, int branch) const noexcept;

  // Branches 1 .. branches(): the intervals of D on which they hold (the last has no end).
  int branches() const noexcept { return static_cast<int>(count_); }
  double begins(int branch) const noexcept { return stable_[branch - 1].begin; }
  double ends(int branch) const noexcept { return stable_[branch - 1].end; }
  double attaches() const noexcept { return attaches_; }  // D where branch 0 ends: -2/(pi lambda)
  // Most negative P on any stable branch.
  double pull_off_force() const noexcept { return pull_off_; }
  double lambda() const noexcept { return lambda_; }

  // Points along the whole curve, unstable parts too, for drawing.
  std::vector<MaugisPoint> points(std::size_t count) const;

 private:
  static constexpr int kDegree = 5;
  static constexpr std::size_t kCells = 1024;

  // A part of a branch, tabulated over y with D = begin + y^4: smooth at a fold, where P grows
  // like a square root, and finest there.
  // Polynomials in the fraction u of a cell of y.
  struct Cell {
    std::array<double, kDegree + 1> force, radius;
    double energy = 0;                       // at the cell's begin
    std::array<double, kDegree + 4> gained;  // since then, over u
  };
  struct Piece {
    double begin, end, cells_per_y;
    std::vector<Cell> cells;
    double energy = 0;        // at the end
    double energy_there = 0;  // the same up to a constant, of the equations of contact
  };
  struct Branch {
    double begin, end;
    std::vector<Piece> pieces;
    double energy_at_end;
  };

  Piece tabulate(bool touching, double from, double to, double begin) const;
  double D_at(bool touching, double parameter) const noexcept;
  inline Value on(const Branch& branch, double D) const noexcept;
  Value beyond(const Piece& table, double D) const noexcept;
  Value jump(double D, int branch) const noexcept;

  double lambda_, attaches_, pull_off_ = 0;
  std::array<Branch, 2> stable_;
  std::size_t count_ = 0;
};

}  // namespace ferrule
