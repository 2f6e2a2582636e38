// What `ferrule view` replays: an episode, a folder of them, or a trial made again.
#pragma once

#include "app/scene_arguments.hpp"
#include "insertion/operator_skill.hpp"
#include "view/recorded.hpp"

namespace ferrule {

struct RecordedViewArguments {
  std::string path;  // episode, folder, or with `trial` a controller; may be empty there
  std::optional<std::uint64_t> trial;
  std::uint64_t seed = 7;
  std::string against;  // a controller, "operator", or none
  bool supervise = false, other_scaling = false;
  OperatorSkill skill = 0.8;  // of the operator
};

class RecordedView {
 public:
  // Throws BadInput, FileTrouble.
  RecordedView(const RecordedViewArguments& arguments, const SceneArguments& scene);

  // JSON of view/recorded.hpp: of everything, where of a folder only the first episode has rows; or
  // of the episode of that name alone. Empty: there is none. Throws BadInput, FileTrouble.
  std::optional<std::string> json(const std::string& file) const;
  // All of it, in one document, with fewer rows.
  Json whole() const;

  const Provenance& provenance() const noexcept { return provenance_; }

 private:
  void find_episodes(const RecordedViewArguments& a);
  void make_trial(const RecordedViewArguments& a, const SceneArguments& scene);

  std::string title_;
  std::vector<std::string> files_;  // of a folder, or one
  std::vector<ReplayRun> trials_;
  Provenance provenance_;
};

}  // namespace ferrule
