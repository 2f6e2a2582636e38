#include "capture/episode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>

#include "capture/natural_order.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/base/error.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kSaysItsStart = 6;  // the format from which on a scene does

// Sticks and other systems write it in capitals; macOS leaves ._NAME.h5 beside, which is none.
bool names_an_episode(const fs::path& path) {
  const std::string ending = path.extension().string();
  return (ending == ".h5" || ending == ".H5") && !path.filename().string().starts_with('.');
}

// Before, y, z and the tilts at the start were the first four of one stream.
void start_as_before(const EpisodeInfo& info, Scene& scene) {
  RandomStream random(info.seed, info.trial, Draw::start);
  Eigen::Vector4d normals;
  for (double& each : normals) each = random.normal();
  scene.start.lateral += scene.start.lateral_sd * normals.head<2>();
  scene.start.tilt += scene.start.tilt_sd * normals.tail<2>();
  std::erase_if(scene.drawn, [](const DrawnNumber& n) { return n.key.starts_with("start."); });
}

}  // namespace

void note_phase(std::vector<PhaseBegin>& phases, Eigen::Index row, const std::string& name) {
  if (name != (phases.empty() ? "" : phases.back().name)) phases.push_back({row, name});
}

std::string phases_text(const std::vector<PhaseBegin>& phases) {
  Json list = Json::array();
  for (const PhaseBegin& phase : phases) list.push_back({phase.row, phase.name});
  return list.empty() ? "" : list.dump();
}

std::vector<PhaseBegin> phases_of(const EpisodeInfo& info, Eigen::Index rows,
                                  const std::string& file) {
  if (info.phases.empty()) return {};
  std::vector<PhaseBegin> phases;
  try {
    for (const auto& each : parse_json(info.phases, file)) {
      const Eigen::Index from = phases.empty() ? 0 : phases.back().row + 1;
      if (!each.at(0).is_number_integer()) throw BadInput("row");
      phases.push_back({each.at(0).get<Eigen::Index>(), each.at(1).get<std::string>()});
      if (phases.back().row < from || phases.back().row >= rows) throw BadInput("row");
    }
  } catch (const std::exception&) {
    throw FileTrouble(fmt::format(
        "{}: damaged: phases is not a list of [first row, name], rows rising and less than {}",
        file, rows));
  }
  return phases;
}

Rule period_rule() {
  return rule::between(1e-6, 1, "must be from 1e-6 to 1");
}

std::string program_version() {
  return FERRULE_VERSION;
}
std::string program_build() {
  return FERRULE_BUILD;
}

EpisodeInfo episode_info(const Scene& scene, const Device& device, std::uint64_t seed,
                         std::uint64_t trial) {
  EpisodeInfo info;
  info.scene = scene.document().dump();
  info.seed = seed;
  info.trial = trial;
  info.version = program_version();
  info.build = program_build();
  if (const Mapping* mapping = device.mapping()) info.mapping = mapping_text(*mapping);
  return info;
}

Scene recorded_scene(const EpisodeInfo& info, const std::string& file) {
  Scene scene = parse_scene(parse_json(info.scene, file), file);
  if (info.format < kSaysItsStart) start_as_before(info, scene);
  return scene;
}

EpisodeRows::EpisodeRows(EpisodeInfo info, Eigen::Index count, Read read)
    : info_(std::move(info)), count_(count), read_(std::move(read)) {}

EpisodeRows::EpisodeRows(const Episode& episode)
    : EpisodeRows(episode.info, episode.rows.rows(), [&](Eigen::Index first, Eigen::Index count) {
        Part part;
        part.rows = episode.rows.middleRows(first, count);
        if (episode.counts.rows() > 0) part.counts = episode.counts.middleRows(first, count);
        return part;
      }) {}

const EpisodeRows::Part& EpisodeRows::part_of(Eigen::Index n) const {
  const Eigen::Index first = n / kBlock * kBlock;
  if (const auto known = parts_.find(first); known != parts_.end()) return known->second;
  if (parts_.size() == kKept) parts_.erase(std::prev(parts_.end()));
  return parts_[first] = read_(first, std::min(kBlock, count_ - first));
}

std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

TrialSetup recorded_setup(const EpisodeInfo& info, const Scene& scene) {
  std::optional<TrialSetup> setup = trial_setup(scene, info.seed, info.trial);
  if (!setup) throw BadInput("the episode's scene: its parts cannot be together");
  return *std::move(setup);
}

RecordedSensor::RecordedSensor(const EpisodeInfo& info, const Scene& scene)
    : SensedWrench(scene_scaling(scene), ForceSensor(scene.sensor, info.seed, info.trial),
                   info.period, scene_tare(scene)) {}

void RecordedSensor::read(const RowVector& row) noexcept {
  SensedWrench::read(row.segment<5>(kHolder.begin).transpose(), row[state_column("hand_x")]);
}

SensedRows sensed_wrench(const Episode& episode, const Scene& scene) {
  RecordedSensor sensed(episode.info, scene);
  const Eigen::Index count = episode.rows.rows();
  SensedRows all;
  all.absolute.resize(count, Eigen::NoChange);
  all.relative.resize(count, Eigen::NoChange);
  for (Eigen::Index n = 0; n < count; ++n) {
    sensed.read(episode.rows.row(n));
    all.absolute.row(n) = sensed.absolute().transpose();
    all.relative.row(n) = sensed.relative().transpose();
  }
  return all;
}

std::string mapping_text(const Mapping& mapping) {
  const auto rows = [&](Eigen::Index from, Eigen::Index count) {
    Json list = Json::array();
    for (Eigen::Index i = from; i < from + count; ++i) {
      list.push_back(Json::array());
      for (Eigen::Index axis = 0; axis < mapping.gain.cols(); ++axis)
        list.back().push_back(mapping.gain(i, axis));
    }
    return list;
  };
  const bool velocity = mapping.kind == Mapping::Kind::velocity;
  const Json json = {{"motion", velocity ? "velocity" : "position"},
                     {"axes", {"X", "Y", "Z", "Rx", "Ry", "Rz"}},
                     {"centre_counts", mapping.centre},
                     {"limit_counts", mapping.limit},
                     {"dead_zone", mapping.dead_zone},
                     {velocity ? "gain_m_s" : "gain_m", rows(0, 3)},
                     {velocity ? "gain_rad_s" : "gain_rad", rows(3, 2)}};
  return json.dump();
}

std::string coupling_text(const Coupling& coupling) {
  return Json{{"stiffness_N_m", coupling.stiffness}, {"damping_N_s_m", coupling.damping}}.dump();
}

std::vector<std::string> episode_files(const std::string& folder) {
  std::error_code error;
  std::vector<std::string> files;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (names_an_episode(entry.path())) files.push_back(entry.path().string());
  if (error) throw FileTrouble(folder + ": cannot be read: " + error.message());
  std::sort(files.begin(), files.end(), natural_less);
  return files;
}

std::vector<std::string> episode_files(const std::vector<std::string>& places) {
  std::error_code error;
  std::vector<std::string> files;
  for (const std::string& place : places) {
    if (fs::is_regular_file(place, error)) {
      files.push_back(place);
      continue;
    }
    const std::vector<std::string> more = episode_files(place);
    files.insert(files.end(), more.begin(), more.end());
  }
  return files;
}

std::string file_name(const std::string& path) {
  return fs::path(path).filename().string();
}

}  // namespace ferrule
