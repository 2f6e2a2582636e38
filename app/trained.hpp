// What controllers and demonstrations say of where they come from, held against what is asked of
// them: their scene, their scaling, the starts that they were trained on.
#pragma once

#include <CLI/CLI.hpp>

#include "app/progress.hpp"
#include "app/provenance.hpp"
#include "controller/trained_on.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

// The scene that the controller of `file` was trained on. Files of before hold its name alone.
BroughtScene brought_by(const TrainedOn& trained, const std::string& file);
// The scene that the episodes of `folder` were recorded in.
BroughtScene brought_by(const DemonstrationSet& set, const std::string& folder);

// For load_demonstrations: progress of it, which Ctrl-C ends.
class Loading {
 public:
  void operator()(std::size_t read, std::size_t of);

 private:
  std::shared_ptr<Progress> progress_;
};

// --other-scaling
void add_other_scaling(CLI::App& verb, bool& allowed);
// Throws BadInput where `scene` scales the hand otherwise than `scaling` of what `who` learned
// from, unless that is `allowed`. An empty scaling is not known: nothing is refused.
void refuse_other_scaling(const std::optional<Scaling>& scaling, const std::string& who,
                          const Scene& scene, bool allowed);

// How many of the trials 0 to `trials` - 1 under `seed` start where an episode of the training did.
std::size_t trained_starts(const TrainedOn& trained, std::uint64_t seed, std::size_t trials);
// What is said of that; empty where there is none.
std::string trained_starts_note(std::size_t trained, std::size_t trials);

}  // namespace ferrule
