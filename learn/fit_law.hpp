// Fits the insertion law (controller/insertion_law.hpp) to demonstrations with Ceres.
//
// Minimised: the sum over all training rows, taken every 10 ms, of Huber's loss of
//   (commanded velocity - law's velocity) / (speed scale),
// gains scaled to order one and bounded, from several starts; the best is kept. The law sees the
// force as it was one reaction time before: that delay is identified first, from the lateral
// velocities, and not imitated (a machine need not wait).
//
// Split by episode: about a fifth is held out and only used for the held-out residual.
// Intervals: 95 %, from the sandwich covariance clustered by episode (rows of one episode are not
// independent) and Student's t with (training episodes - 1) degrees of freedom.
#pragma once

#include <string>

#include "controller/controller_file.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

struct FitReport {
  ControllerFile controller;
  std::string summary;  // Ceres' own, one line
  int iterations = 0;
  double explained = 0;  // share of the velocities' variance that the law explains, training
};

// `seed` draws the split. Throws BadInput where the demonstrations are too few (fewer than 3
// successful ones, or fewer than 300 rows in 10 ms steps) or tell nothing about the answer to
// force.
FitReport fit_law(const DemonstrationSet& set, std::uint64_t seed);

}  // namespace ferrule
