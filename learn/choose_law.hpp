// Which law the demonstrations can bear: k-fold cross-validation over episodes, never over rows
// (rows of one episode know of each other).
//
// The episodes are dealt into five folds (fewer if there are fewer episodes); each law is fitted to
// the rows, every 50 ms, of all folds but one, and predicts the velocities of the one left out,
// rows every 10 ms. An episode's error is the root mean square of the velocity error, and a law's
// the mean over all episodes. The law chosen is the one with the fewest gains whose error is no
// more than one standard error above the smallest (Breiman et al. 1984).
#pragma once

#include "learn/solve_law.hpp"

namespace ferrule {

// Errors of all laws, in the order of kLaws; a law without a solution in some fold has NaN. At
// least two episodes; their order decides which fold they are in. Once `progress` is false, the
// laws that are left have NaN.
std::vector<CrossValidated> cross_validate(const std::vector<Samples>& episodes,
                                           const LawScales& scales,
                                           const SolveProgress& progress = {});

// Throws BadInput if no law has a finite error.
LawKind simplest_within_one_standard_error(const std::vector<CrossValidated>& laws);

}  // namespace ferrule
