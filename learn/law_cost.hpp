// How far a law is from an episode, for Ceres.
//
// With r_i the error (3) of row i in units of the speed scale, J_i its Jacobian to the scaled gains,
// rho Huber's loss and w_i = rho'(|r_i|^2) its weight, an episode is one residual block of n + 2
// residuals for n gains: the last column of the triangle R of
//   QR = [sqrt(w_i) J_i, sqrt(w_i) r_i] over all rows i,
// whose first n columns are its Jacobian, and sqrt(sum_i (rho_i - w_i |r_i|^2)), whose Jacobian is
// zero. Cost and gradient are those of all rows, and so is the Gauss-Newton matrix of a weighted
// least squares; a block takes as much memory as a row.
#pragma once

#include <memory>
#include <vector>

#include "controller/law.hpp"
#include "learn/intervals.hpp"
#include "learn/samples.hpp"

namespace ceres {
class CostFunction;
}

namespace ferrule {

inline constexpr double kVelocityHuber = 0.2;  // threshold of rho, of the speed scale

// What makes gains and errors of order one: gain i is gains[i] times its scaled one, and an error
// is (law's velocity - commanded velocity) / speed.
struct LawUnits {
  std::vector<double> gains;
  double speed;  // of the hand [m/s], > 0
};

// Keeps references to `episode` and `units`.
std::unique_ptr<ceres::CostFunction> episode_cost(LawKind kind, const Samples& episode,
                                                  const LawUnits& units);

// The sums of an episode at scaled gains that are of a law.
EpisodeSums episode_sums(LawKind kind, const Samples& episode, const LawUnits& units,
                         const std::vector<double>& scaled);

}  // namespace ferrule
