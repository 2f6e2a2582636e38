// The learners that `ferrule compare` fits.
#pragma once

#include "app/compared.hpp"

namespace ferrule {

// The baselines in trials of `scene`, and those that were given by their names.
std::vector<Candidate> without_learning(const CompareArguments& a, const Scene& scene,
                                        const DemonstrationSet& set);
// What --learners may name.
std::vector<std::string> learner_keys();

// `which`: the demonstrations of the set, unlike any other of the command. Throws BadInput where
// they are too few or tell nothing, Stopped at Ctrl-C.
Candidate fitted(const CompareArguments& a, const ChosenLearner& chosen,
                 const DemonstrationSet& set, const std::string& which);

// Appends what each learner of --learners (all unless given) made of the demonstrations; returns
// those that could. Throws as fitted, BadInput only where --learners names one that could not.
std::vector<ChosenLearner> add_learned(const CompareArguments& a, const DemonstrationSet& set,
                                       std::vector<Candidate>& candidates);

// What --ablate asks for: `whole`, which `learner` made of the demonstrations (null: it was given),
// without each of the things in turn. Where there is nothing to take away it is left out; where
// nothing can be learned without, with a note. Of a learner the seed is a.fit_seed.
std::vector<Climber> ablated(const CompareArguments& a, const DemonstrationSet& set,
                             const ChosenLearner* learner, const Candidate& whole);

}  // namespace ferrule
