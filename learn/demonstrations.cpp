#include "learn/demonstrations.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {

Eigen::Index rows_per_step(double period) noexcept {
  return std::max<Eigen::Index>(1, std::lround(kStep / period));
}

Demonstration demonstration(const EpisodeRows& episode, const Scene& scene,
                            const std::string& file) {
  const EpisodeInfo& info = episode.info();
  const Eigen::Index stride = rows_per_step(info.period);
  Demonstration d;
  d.file = file;
  d.operator_ = info.operator_;
  d.seed = info.seed;
  d.trial = info.trial;
  d.outcome = info.outcome;
  d.period = static_cast<double>(stride) * info.period;
  d.speed_limit = scene_scaling(scene).motion * scene.limits.speed;
  const Eigen::Index rows = (episode.count() + stride - 1) / stride;
  d.velocity.resize(rows, Eigen::NoChange);
  d.tilt_rates.resize(rows, Eigen::NoChange);
  d.observations.reserve(static_cast<std::size_t>(rows));
  RecordedSensor sensor(info, scene);
  const double entrance = registered_entrance(scene);
  const std::vector<PhaseBegin> phases = phases_of(info, episode.count(), file);
  const HandPose start = block(episode.row(0), kHandPose).transpose();
  Observation before{};
  for (Eigen::Index n = 0; n < episode.count(); ++n) {
    const RowVector row = episode.row(n);
    sensor.read(row);
    const Observation now = observe(sensor.relative(), block(row, kHandPose).transpose(), start,
                                    entrance, row[kTime.begin]);
    if (const std::size_t k = d.phases.size(); k < phases.size() && phases[k].row == n)
      d.phases.push_back({phases[k].name, now.time, n > 0 ? before : now, now});
    before = now;
    if (n % stride != 0) continue;
    d.velocity.row(n / stride) = row.segment<3>(kCommand.begin);
    d.tilt_rates.row(n / stride) = row.segment<2>(kCommand.begin + 3);
    d.observations.push_back(now);
  }
  return d;
}

namespace {

constexpr std::size_t kFewest = 3;  // demonstrations that a fit needs

template <class Document>
void add_new(std::vector<Document>& documents, const Document& document) {
  if (std::find(documents.begin(), documents.end(), document) == documents.end())
    documents.push_back(document);
}

}  // namespace

void DemonstrationSet::add(const EpisodeRows& episode, const std::string& file,
                           const std::string& hash) {
  const Scene scene = recorded_scene(episode.info(), file);
  const Scaling its = scene_scaling(scene);
  if (!scaling) {
    scaling = its;
    force_limit = scene.limits.force;
  }
  if (its != *scaling)
    throw BadInput(file +
                   ": was recorded with another scaling than the episodes before it; a law is "
                   "learned in one hand's world");
  add_new(undrawn_documents, undrawn(scene.document()));
  if (documents.size() < kMostDocuments) add_new(documents, episode.info().scene);
  if (std::find(scenes.begin(), scenes.end(), scene.name) == scenes.end())
    scenes.insert(std::upper_bound(scenes.begin(), scenes.end(), scene.name), scene.name);
  speed_scale = std::max(speed_scale, its.motion * scene.limits.speed);
  speed_limit = std::max(speed_limit, scene.limits.speed);
  force_limit = std::min(force_limit, scene.limits.force);
  operators.push_back(episode.info().operator_);
  if (episode.info().outcome != Outcome::inserted) {
    ++unsuccessful;
    return;
  }
  demonstrations.push_back(demonstration(episode, scene, file));
  demonstrations.back().sha1 = hash;
  while (rows() > kMostRows && demonstrations.size() > kFewest) {
    demonstrations.erase(
        std::max_element(demonstrations.begin(), demonstrations.end(),
                         [](const auto& a, const auto& b) { return a.sha1 < b.sha1; }));
    ++beyond;
  }
}

Eigen::Index DemonstrationSet::rows() const noexcept {
  Eigen::Index sum = 0;
  for (const Demonstration& d : demonstrations) sum += d.rows();
  return sum;
}

DemonstrationSet load_demonstrations(
    const std::string& folder, const std::function<void(std::size_t, std::size_t)>& progress) {
  return load_demonstrations(episode_files(folder), progress);
}

DemonstrationSet load_demonstrations(
    const std::vector<std::string>& files,
    const std::function<void(std::size_t, std::size_t)>& progress) {
  DemonstrationSet set;
  EpisodeCopies copies;
  std::size_t read = 0;
  for (const std::string& file : files) {
    if (progress) progress(read++, files.size());
    std::string hash;
    const EpisodeRows episode = open_episode(file, &hash);
    if (const auto copy = copies.seen(episode, file))
      set.copies.push_back(*copy);
    else
      set.add(episode, file, hash);
  }
  return set;
}

TrainedOn trained_on(const DemonstrationSet& set, const std::vector<const Demonstration*>& training,
                     const std::vector<const Demonstration*>& held_out, std::uint64_t seed) {
  const auto episodes = [](const std::vector<const Demonstration*>& part) {
    std::vector<TrainedEpisode> list;
    for (const Demonstration* d : part) list.push_back({d->file, d->sha1, d->seed, d->trial});
    std::sort(list.begin(), list.end(),
              [](const auto& a, const auto& b) { return a.file < b.file; });
    return list;
  };
  TrainedOn t;
  t.scenes = set.scenes;
  t.episodes = episodes(training);
  t.held_out = episodes(held_out);
  t.seed = seed;
  t.scaling = set.scaling;
  t.speed_limit = set.speed_limit;
  t.force_limit = set.force_limit;
  if (set.undrawn_documents.size() == 1) t.scene = set.undrawn_documents.front();
  return t;
}

void refuse_too_few(const DemonstrationSet& set) {
  if (set.demonstrations.size() < kFewest)
    throw BadInput(fmt::format(
        "too few demonstrations: {} successful ({} unsuccessful left out); {} are needed",
        set.demonstrations.size(), set.unsuccessful, kFewest));
}

}  // namespace ferrule
