#include "capture/episode.hpp"

#include <algorithm>
#include <array>
#include <ctime>
#include <filesystem>

#include "capture/child.hpp"
#include "capture/stored_episode.hpp"
#include "sim/base/written_file.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

}  // namespace

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
  info.scene = scene.document.dump();
  info.seed = seed;
  info.trial = trial;
  info.version = program_version();
  info.build = program_build();
  if (const Mapping* mapping = device.mapping()) info.mapping = mapping_text(*mapping);
  return info;
}

Scene recorded_scene(const EpisodeInfo& info, const std::string& file) {
  return parse_scene(parse_json(info.scene, file), file);
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

namespace {

struct Written {
  std::size_t done, all;  // rows
};

// Writes rows to `path`, in a child; `name` is for messages. The last that it sends is that all are
// on the disk.
void write_rows(const std::string& path, const std::string& name, const EpisodeRows& rows,
                Child::Parent& parent) {
  EpisodeTables tables(rows, recorded_scene(rows.info(), name));
  hdf5::Content content = tables.content();
  content.attributes["/"][kInputsHash] =
      inputs_sha1(content, [&](const std::string& of, auto first, auto) -> hdf5::Matrix {
        const EpisodeRows::Part& part = rows.part_of(first);
        if (of == kCountsPath) return part.counts.cast<double>();
        return part.rows.middleCols<kPose>(kCommand.begin);
      });
  Written written{0, static_cast<std::size_t>(rows.count())};
  hdf5::write(path, name, content, [&] {
    if (written.done > 0) parent.send(&written, sizeof written);
    std::vector<hdf5::Matrix> values = tables.next();
    written.done += static_cast<std::size_t>(values.front().rows());
    return values;
  });
  parent.send(&written, sizeof written);
}

// Lets a child write a file beside its name.
WrittenFile write_in_child(
    const std::string& file, const WriteProgress& progress,
    const std::function<void(const std::string& path, Child::Parent& parent)>& work) {
  return WrittenFile(file, [&](const std::string& path) {
    Child child(file, Child::Work::writes, [&](Child::Parent& parent) { work(path, parent); });
    Written written{};
    do {
      child.receive(&written, sizeof written);
      if (progress) progress(written.done, written.all);
    } while (written.done < written.all);
  });
}

}  // namespace

void write_episode(const std::string& file, const EpisodeRows& rows,
                   const WriteProgress& progress) {
  write_in_child(file, progress, [&](const std::string& path, Child::Parent& parent) {
    write_rows(path, file, rows, parent);
  }).commit(false);
}

void rate_episode(const std::string& file, int stars) {
  write_in_child(file, {}, [&](const std::string& path, Child::Parent& parent) {
    const StoredEpisode stored(file);
    EpisodeInfo info = stored.info();
    info.rating = stars;
    write_rows(path, file, stored.rows(info), parent);
  }).commit();
}

std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

RecordedSensor::RecordedSensor(const EpisodeInfo& info, const Scene& scene)
    : SensedWrench(scene_scaling(scene), ForceSensor(scene.sensor, info.seed, info.trial),
                   info.period, scene_tare(scene)) {}

void RecordedSensor::read(const RowVector& row) noexcept {
  SensedWrench::read(row.segment<5>(kHolder.begin).transpose(),
                     row[kStates.begin + 5]);  // of the holder at the tip's scale
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
    if (entry.path().extension() == ".h5") files.push_back(entry.path().string());
  if (error) throw FileTrouble(folder + ": cannot be read: " + error.message());
  std::sort(files.begin(), files.end());
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
