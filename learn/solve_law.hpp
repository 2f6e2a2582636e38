// The gains of one law from rows, with Ceres.
//
// Minimised: the sum over all rows of Huber's loss of
//   (commanded velocity - law's velocity) / (speed scale),
// gains scaled to order one and bounded, from several starts; the best is kept (where the effort is
// exact, the best on every fifth row, refined on all). A law that contains a simpler one also
// starts from the solution of that one, so it never fits worse.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "controller/law_file.hpp"
#include "learn/samples.hpp"

namespace ferrule {

// What makes residuals and gains of order one.
struct LawScales {
  double speed, depth;  // of the hand [m/s], [m], > 0
};

struct LawSolution {
  std::vector<double> gains;   // in the order of the law's table; empty if no start converged
  std::vector<double> scaled;  // the same relative to what makes them of order one
  double cost;                 // of the scaled residuals; infinite if no start converged
  std::string summary;         // Ceres' own, one line
  int iterations = 0;
};

// To the last digits, or as good as predictions need.
enum class Effort { exact, rough };

// Called after every iteration of Ceres with how many solves of `all` are done. False ends the
// solving with the best so far.
using SolveProgress = std::function<bool(std::size_t done, std::size_t all)>;

LawSolution solve_law(LawKind kind, const std::vector<Samples>& episodes, const LawScales& scales,
                      Effort effort = Effort::exact, const SolveProgress& progress = {});

// The law whose gains are `held` where they are not NaN, cut to their bounds; the others are solved
// for, from a solution of all.
LawSolution solve_beside(LawKind kind, const std::vector<Samples>& episodes,
                         const LawScales& scales, const LawSolution& from,
                         const std::vector<double>& held, const SolveProgress& progress = {});

// The solution's gains, with 95 % intervals (learn/intervals.hpp) cut to the gains' bounds. A gain
// at its bound has none, nor has one that the data tell nothing of.
std::vector<FittedGain> law_gains(LawKind kind, const std::vector<Samples>& episodes,
                                  const LawScales& scales, const LawSolution& solution);

// Mean square of a law's velocity error in one episode [m^2/s^2]; NaN without rows.
double mean_square_error(const Law& law, const Samples& episode);

}  // namespace ferrule
