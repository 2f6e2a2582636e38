#include "learn/demonstrations.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "insertion/scene_scaling.hpp"
#include "sim/content_hash.hpp"

namespace ferrule {

Demonstration demonstration(const Episode& episode, const Scene& scene, const std::string& file) {
  const Rows& rows = episode.rows;
  Demonstration d;
  d.file = file;
  d.outcome = episode.info.outcome;
  d.period = episode.info.period;
  d.speed_limit = scene_scaling(scene).motion * scene.limits.speed;
  const auto wrench = sensed_wrench(episode, scene).relative;
  d.velocity = rows.middleCols<3>(kCommand.begin);
  for (Eigen::Index n = 0; n < rows.rows(); ++n)
    d.observations.push_back({wrench.row(n).transpose(), std::max(0.0, -rows(n, kHandPose.begin)),
                              rows(n, kTime.begin)});
  return d;
}

DemonstrationSet load_demonstrations(const std::string& folder) {
  DemonstrationSet set;
  Scaling first{};
  std::string first_file;
  for (const std::string& file : episode_files(folder)) {
    const Episode episode = read_episode(file);
    const Scene scene = parse_scene(parse_json(episode.info.scene, file), file);
    const Scaling scaling = scene_scaling(scene);
    if (first_file.empty()) {
      first_file = file;
      first = scaling;
    }
    if (std::find(set.documents.begin(), set.documents.end(), scene.document) ==
        set.documents.end()) {
      set.documents.push_back(scene.document);
      if (std::find(set.scenes.begin(), set.scenes.end(), scene.name) == set.scenes.end())
        set.scenes.push_back(scene.name);
    }
    set.speed_scale = std::max(set.speed_scale, scaling.motion * scene.limits.speed);
    if (scaling.motion != first.motion || scaling.force != first.force)
      throw BadInput(file + ": was recorded with another scaling than " + first_file +
                     "; a law is learned in one hand's world");
    if (episode.info.outcome == Outcome::inserted) {
      set.demonstrations.push_back(demonstration(episode, scene, file));
      set.demonstrations.back().sha1 = sha1(read_text(file));
    } else {
      ++set.unsuccessful;
    }
  }
  std::sort(set.scenes.begin(), set.scenes.end());
  return set;
}

std::vector<TrainedEpisode> trained_episodes(const std::vector<const Demonstration*>& set) {
  std::vector<TrainedEpisode> episodes;
  for (const Demonstration* d : set) episodes.push_back({d->file, d->sha1});
  std::sort(episodes.begin(), episodes.end(),
            [](const auto& a, const auto& b) { return a.file < b.file; });
  return episodes;
}

void refuse_too_few(const DemonstrationSet& set) {
  constexpr std::size_t kFewest = 3;
  if (set.demonstrations.size() < kFewest)
    throw BadInput(fmt::format(
        "too few demonstrations: {} successful ({} unsuccessful left out); {} are needed",
        set.demonstrations.size(), set.unsuccessful, kFewest));
}

}  // namespace ferrule
