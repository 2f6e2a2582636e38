// The learners that `ferrule compare` fits.
#pragma once

#include "app/compared.hpp"

namespace ferrule {

// The baselines in trials of `scene`, and those that were given by their names.
std::vector<Compared> without_learning(const CompareArguments& a, const Scene& scene,
                                       const DemonstrationSet& set);
// What --learners may name.
std::vector<std::string> learner_keys();

// `which`: the demonstrations of the set, unlike any other of the command. Throws BadInput where
// they are too few or tell nothing, Stopped at Ctrl-C.
Compared fitted(const CompareArguments& a, const ChosenLearner& chosen, const DemonstrationSet& set,
                const std::string& which);

// What each learner of --learners (all unless given) made of the demonstrations, of those that
// could. Throws as fitted, BadInput only where --learners names one that could not.
std::vector<Compared> fitted_by_all(const CompareArguments& a, const DemonstrationSet& set);

// What --ablate asks for: `whole`, which was learned of the demonstrations or given, without each
// of the things in turn. Where there is nothing to take away it is left out; where nothing can be
// learned without, with a note.
std::vector<Compared> ablated(const CompareArguments& a, const DemonstrationSet& set,
                              const Compared& whole);

}  // namespace ferrule
