#include "capture/episode.hpp"

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "capture/hdf5.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/sensed_wrench.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;
using hdf5::Handle;
using hdf5::Matrix;
using hdf5::Reader;
using hdf5::Table;
using hdf5::Writer;

constexpr const char* kFormat = "ferrule episode";
constexpr std::int64_t kFormatVersion = 1;
constexpr const char* kDemo = "/data/demo_0";
constexpr const char* kCountsPath = "/data/demo_0/raw/counts";

Json environment(const EpisodeInfo& info) {
  return {{"env_name", "ferrule"},
          {"type", 0},
          {"env_type", 0},
          {"env_version", info.version},
          {"env_kwargs", {{"scene", Json::parse(info.scene)}, {"period_s", info.period}}}};
}

// Column `k` of actions is the command divided by this [m/s], [rad/s]. Twice the scene's speed
// limit leaves room for a hand that is faster than a controller may be.
Eigen::Matrix<double, 5, 1> action_scale(const Scene& scene) {
  Eigen::Matrix<double, 5, 1> scale;
  scale << Eigen::Vector3d::Constant(2 * scene_scaling(scene).motion * scene.limits.speed), 1, 1;
  return scale;
}

Matrix one_row_later(const Matrix& values) {
  Matrix later = values;
  if (values.rows() > 1) later.topRows(values.rows() - 1) = values.bottomRows(values.rows() - 1);
  return later;
}

std::string rows_path(const Block& b) {
  return std::string(kDemo) + (b.begin == kStates.begin ? "/" : "/rows/") + b.name;
}

// What is derived from the rows for readers of the demonstration layout.
std::vector<Table> derived_tables(const Episode& episode, const Scene& scene) {
  const Rows& rows = episode.rows;
  const auto count = rows.rows();
  const std::string demo = kDemo;
  const Matrix commands = rows.middleCols(kCommand.begin, kCommand.width);
  const Matrix actions = (commands * action_scale(scene).cwiseInverse().asDiagonal());
  Matrix rewards = Matrix::Zero(count, 1), dones = Matrix::Zero(count, 1);
  const Matrix wrench = sensed_wrench(episode, scene).absolute;
  const Matrix depth = 1e3 * (-rows.col(kHandPose.begin)).cwiseMax(0.0);
  if (count > 0) {
    rewards(count - 1, 0) = episode.info.outcome == Outcome::inserted ? 1 : 0;
    dones(count - 1, 0) = 1;
  }
  const Matrix time = rows.middleCols(kTime.begin, 1);

  std::vector<Table> tables = {
      {demo + "/actions", actions.cwiseMax(-1.0).cwiseMin(1.0), "1",
       "command / scale, cut to [-1, 1]"},
      {demo + "/rewards", rewards, "1", "1 where the fibre is inserted", Table::exact, true},
      {demo + "/dones", dones, "1", "1 in the last row", Table::whole, true}};
  for (const bool next : {false, true}) {
    const std::string group = demo + (next ? "/next_obs" : "/obs");
    const auto add = [&](const char* key, const Matrix& values, const char* unit,
                         const char* columns) {
      tables.push_back(
          {group + key, next ? one_row_later(values) : values, unit, columns, Table::single});
    };
    add("/wrench_N", wrench, "N N N N.m N.m", "Fx Fy Fz My Mz; in the hand's world");
    add("/depth_mm", depth, "mm", "of the hand past the entrance; in the hand's world");
    add("/time_s", time, "s", "since the start");
  }
  return tables;
}

void write_tables(const Writer& out, const Episode& episode, const Scene& scene) {
  for (const char* group : {"/rows", "/obs", "/next_obs"}) out.group(kDemo + std::string(group));
  for (const Block& b : kBlocks)
    out.table({rows_path(b), episode.rows.middleCols(b.begin, b.width), b.unit, b.columns,
               Table::exact, b.width == 1});
  if (!episode.info.mapping.empty()) {
    out.group(kDemo + std::string("/raw"));
    out.table({kCountsPath, episode.counts.cast<double>(), "1", "X Y Z Rx Ry Rz; of the device",
               Table::whole});
  }
  for (const Table& table : derived_tables(episode, scene)) {
    const Handle set = out.table(table);
    if (!table.path.ends_with("/actions")) continue;
    out.attribute(set, "scale_m_s", action_scale(scene)[0]);
    out.attribute(set, "scale_rad_s", action_scale(scene)[4]);
  }
}

}  // namespace

std::string program_version() {
  return FERRULE_VERSION;
}
std::string program_build() {
  return FERRULE_BUILD;
}

Scene recorded_scene(const Episode& episode, const std::string& file) {
  return parse_scene(parse_json(episode.info.scene, file), file);
}

void write_episode(const std::string& file, const Episode& episode) {
  const EpisodeInfo& info = episode.info;
  const Scene scene = parse_scene(parse_json(info.scene, file), file);
  Writer out(file);
  const hid_t h5 = out.root();
  out.attribute(h5, "format", std::string(kFormat));
  out.attribute(h5, "format_version", kFormatVersion);
  out.attribute(h5, "ferrule_version", info.version);
  out.attribute(h5, "build", info.build);
  out.attribute(h5, "scene", info.scene);
  out.attribute(h5, "operator", info.operator_);
  out.attribute(h5, "seed", info.seed);
  out.attribute(h5, "trial", info.trial);
  out.attribute(h5, "period_s", info.period);
  out.attribute(h5, "alpha_x", scene_scaling(scene).motion);
  out.attribute(h5, "alpha_f", scene_scaling(scene).force);
  out.attribute(h5, "outcome", std::string(name(info.outcome)));
  for (const auto& [key, value] : {std::pair{"mapping", &info.mapping},
                                   {"coupling", &info.coupling},
                                   {"loop", &info.loop},
                                   {"why", &info.why}})
    if (!value->empty()) out.attribute(h5, key, *value);
  if (info.rating != 0) out.attribute(h5, "rating", static_cast<std::int64_t>(info.rating));
  {
    const Handle data = out.group("/data");
    out.attribute(data, "total", static_cast<std::int64_t>(episode.rows.rows()));
    out.attribute(data, "env_args", environment(info).dump());
    const Handle demo = out.group(kDemo);
    out.attribute(demo, "num_samples", static_cast<std::int64_t>(episode.rows.rows()));
    write_tables(out, episode, scene);
  }
  write_text(file, out.image(), false);
}

Episode read_episode(const std::string& file) {
  if (!fs::is_regular_file(file)) throw FileTrouble(file + ": no such file");
  const Reader in(file, "a ferrule episode");
  if (in.text("format") != kFormat) throw FileTrouble(file + ": not a ferrule episode");
  if (const auto version = in.whole("format_version"); version != kFormatVersion)
    throw FileTrouble(file + ": episode format " + std::to_string(version) +
                      "; this program reads format " + std::to_string(kFormatVersion));
  Episode episode;
  EpisodeInfo& info = episode.info;
  info.version = in.text("ferrule_version");
  info.build = in.text("build");
  info.scene = in.text("scene");
  info.operator_ = in.text("operator");
  info.seed = in.whole("seed");
  info.trial = in.whole("trial");
  info.period = in.number("period_s");
  try {
    info.outcome = outcome_from_name(in.text("outcome"));
    parse_scene(parse_json(info.scene, "scene"), "scene");
  } catch (const BadInput& error) {
    throw FileTrouble(file + ": damaged: " + error.what());
  }
  for (const auto& [key, value] : {std::pair{"mapping", &info.mapping},
                                   {"coupling", &info.coupling},
                                   {"loop", &info.loop},
                                   {"why", &info.why}})
    if (in.has(key)) *value = in.text(key);
  if (in.has("rating")) info.rating = static_cast<int>(in.whole("rating"));
  if (!(info.period > 0)) throw FileTrouble(file + ": damaged: period_s is not positive");
  const Eigen::Index count = in.table(rows_path(kTime), 1, -1).rows();
  if (count == 0) throw FileTrouble(file + ": damaged: it holds no rows");
  episode.rows.resize(count, Eigen::NoChange);
  for (const Block& b : kBlocks)
    episode.rows.middleCols(b.begin, b.width) = in.table(rows_path(b), b.width, count);
  if (!info.mapping.empty())
    episode.counts = in.table(kCountsPath, kRawAxes, count).cast<std::int32_t>();
  return episode;
}

SensedRows sensed_wrench(const Episode& episode, const Scene& scene) {
  const EpisodeInfo& info = episode.info;
  SensedWrench sensed(scene_scaling(scene), ForceSensor(scene.sensor, info.seed, info.trial),
                      info.period);
  const Eigen::Index count = episode.rows.rows();
  SensedRows all;
  all.absolute.resize(count, Eigen::NoChange);
  all.relative.resize(count, Eigen::NoChange);
  for (Eigen::Index n = 0; n < count; ++n) {
    sensed.read(episode.rows.row(n).segment<5>(kHolder.begin).transpose());
    all.absolute.row(n) = sensed.absolute().transpose();
    all.relative.row(n) = sensed.relative().transpose();
  }
  return all;
}

std::optional<Difference> derived_difference(const std::string& file, const Episode& episode) {
  const Reader in(file, "a ferrule episode");
  const Scene scene = recorded_scene(episode, file);
  const double rows = static_cast<double>(episode.rows.rows());
  const std::string actions = kDemo + std::string("/actions");
  const struct {
    const char *key, *place;
    double expected;
  } attributes[] = {{"alpha_x", "/", scene_scaling(scene).motion},
                    {"alpha_f", "/", scene_scaling(scene).force},
                    {"total", "/data", rows},
                    {"num_samples", kDemo, rows},
                    {"scale_m_s", actions.c_str(), action_scale(scene)[0]},
                    {"scale_rad_s", actions.c_str(), action_scale(scene)[4]}};
  for (const auto& [key, place, expected] : attributes)
    if (const double recorded = in.number(key, place); recorded != expected)
      return Difference{0, std::string("attribute ") + key, recorded, expected};
  if (in.text("env_args", "/data") != environment(episode.info).dump())
    return Difference{0, "attribute env_args", 0, 0};
  for (const Table& table : derived_tables(episode, scene)) {
    const auto width = static_cast<int>(table.values.cols());
    const Matrix recorded = in.table(table.path, width, table.values.rows());
    for (Eigen::Index n = 0; n < recorded.rows(); ++n)
      for (int c = 0; c < width; ++c) {
        double expected = table.values(n, c);
        if (table.stored == Table::single) expected = static_cast<float>(expected);
        if (std::memcmp(&recorded(n, c), &expected, sizeof(double)) != 0)
          return Difference{static_cast<std::size_t>(n), table.path + "[" + std::to_string(c) + "]",
                            recorded(n, c), expected};
      }
  }
  return std::nullopt;
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

}  // namespace ferrule
