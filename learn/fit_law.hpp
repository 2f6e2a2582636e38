// Fits a parametric law (controller/law.hpp) to demonstrations.
//
// Split by episode: about a fifth is held out and only used for the held-out residual. The law sees
// the force as it was one reaction time before: that delay is identified first, from the lateral
// velocities of all training episodes, and not imitated (a machine need not wait). Where the hands
// tilted under moments, the law gets tilt gains (learn/tilt_yields.hpp). Where the law is
// not given it is chosen by cross-validation over the training episodes (learn/choose_law.hpp).
#pragma once

#include "learn/learner.hpp"

namespace ferrule {

struct LawFit {
  LawFile controller;
  std::string summary;  // Ceres' own, one line
  int iterations = 0;
  double explained = 0;  // share of the velocities' variance that the law explains, training
};

// `seed` draws the split; `kind` empty: chosen. Throws BadInput where the demonstrations are too
// few (fewer than 3 successful ones, or fewer than 300 rows in 10 ms steps) or tell nothing about
// the answer to force; and where `progress` ended it before there was any solution.
LawFit fit_law(const DemonstrationSet& set, std::uint64_t seed,
               std::optional<LawKind> kind = LawKind::insertion,
               const LearnerProgress& progress = {});

// fit_law in the table of learners.
Learner law_learner();

}  // namespace ferrule
