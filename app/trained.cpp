#include "app/trained.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/interrupt.hpp"

namespace ferrule {

BroughtScene brought_by(const TrainedOn& trained, const std::string& file) {
  const std::string who = trained.partial ? file + " (whose fit was stopped)" : file;
  BroughtScene brought{trained.scene, who + " was trained on", ""};
  if (!brought.document.is_null()) return brought;
  const std::vector<std::string> shipped = shipped_scenes();
  const bool one = trained.scenes.size() == 1;
  const bool made = trained.episodes.empty();
  if (one && (made || !trained.scaling) &&
      std::find(shipped.begin(), shipped.end(), trained.scenes[0]) != shipped.end())
    return {load_scene(trained.scenes[0]).document(),
            file + (made ? " was made for" : " was trained on (it stores the name only)"), ""};
  brought.open = fmt::format("{} was trained on {}{}, not on one scene that it holds", file,
                             fmt::join(trained.scenes, ", "), one ? " with changing values" : "");
  return brought;
}

BroughtScene brought_by(const DemonstrationSet& set, const std::string& folder) {
  BroughtScene brought{{}, folder + " was recorded in", ""};
  if (set.undrawn_documents.size() == 1)
    brought.document = set.undrawn_documents.front();
  else
    brought.open = fmt::format("{} was recorded in {} different scenes: {}", folder,
                               set.undrawn_documents.size(), fmt::join(set.scenes, ", "));
  return brought;
}

void Loading::operator()(std::size_t read, std::size_t of) {
  end_if_interrupted();
  if (!progress_) progress_ = std::make_shared<Progress>("reading", of);
  (*progress_)(read);
}

void add_other_scaling(CLI::App& verb, bool& allowed) {
  verb.add_flag("--other-scaling", allowed,
                "Allow a scene whose scaling differs from that of the training");
}

void refuse_other_scaling(const std::optional<Scaling>& scaling, const std::string& who,
                          const Scene& scene, bool allowed) {
  const std::string trouble = allowed ? "" : scaling_trouble(scaling, who, scene);
  if (!trouble.empty()) throw BadInput(trouble + "; --other-scaling allows it");
}

std::size_t trained_starts(const TrainedOn& trained, std::uint64_t seed, std::size_t trials) {
  std::size_t count = 0;
  for (const auto* list : {&trained.episodes, &trained.held_out})
    for (const TrainedEpisode& e : *list)
      count += e.seed == seed && e.trial.value_or(trials) < trials;
  return count;
}

std::string trained_starts_note(std::size_t trained, std::size_t trials) {
  if (trained == 0) return {};
  return fmt::format(
      "note: {} of the {} trials begin where a demonstration did (the same seed) and test no new "
      "start; choose another --seed\n",
      trained, trials);
}

}  // namespace ferrule
