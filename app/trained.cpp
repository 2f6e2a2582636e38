#include "app/trained.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

constexpr double kSame = 1e-9;  // relative

bool differ(double a, double b) {
  return std::abs(a - b) > kSame * std::abs(b);
}

}  // namespace

BroughtScene brought_by(const TrainedOn& trained, const std::string& file) {
  const std::string who = trained.partial ? file + " (whose fit was stopped)" : file;
  BroughtScene brought{trained.scene, who + " was trained on", ""};
  if (!brought.document.is_null()) return brought;
  const std::vector<std::string> shipped = shipped_scenes();
  const bool one = trained.scenes.size() == 1;
  if (one && !trained.scaling &&
      std::find(shipped.begin(), shipped.end(), trained.scenes[0]) != shipped.end())
    return {load_scene(trained.scenes[0]).document,
            file + " was trained on (of which it holds the name alone)", ""};
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
                "Drive a scene that scales the hand otherwise than those learned from");
}

void refuse_other_scaling(const std::optional<Scaling>& scaling, const std::string& who,
                          const Scene& scene, bool allowed) {
  if (allowed || !scaling) return;
  const Scaling here = scene_scaling(scene);
  if (!differ(here.motion, scaling->motion) && !differ(here.force, scaling->force)) return;
  throw BadInput(fmt::format(
      "{}: {} scales the hand otherwise (alpha_x {:.6g}, alpha_f {:.6g}) than what it learned from "
      "({:.6g}, {:.6g}): what was learned there means nothing here; --other-scaling does it "
      "all the same",
      who, scene.name, here.motion, here.force, scaling->motion, scaling->force));
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
      "note: {} of the {} trials begin where a demonstration did (the same seed): they say nothing "
      "of starts that were not seen; take another --seed\n",
      trained, trials);
}

}  // namespace ferrule
