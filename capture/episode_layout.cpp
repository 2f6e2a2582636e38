#include "capture/episode_layout.hpp"

#include <algorithm>

#include "insertion/scene_scaling.hpp"
#include "sim/base/content_hash.hpp"

namespace ferrule {
namespace {

using hdf5::Content;
using hdf5::Matrix;
using hdf5::Table;

constexpr const char* kTimeScale = "/data/demo_0/time";

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

std::map<std::string, Json> root_attributes(const EpisodeInfo& info, const Scene& scene) {
  std::map<std::string, Json> root = {{"format", kFormat},
                                      {"ferrule_version", info.version},
                                      {"build", info.build},
                                      {"scene", info.scene},
                                      {"operator", info.operator_},
                                      {"seed", info.seed},
                                      {"trial", info.trial},
                                      {"period_s", info.period},
                                      {"alpha_x", scene_scaling(scene).motion},
                                      {"alpha_f", scene_scaling(scene).force},
                                      {"outcome", name(info.outcome)}};
  for (const auto& [key, value] : optional_texts(info))
    if (!value->empty()) root[key] = *value;
  if (info.rating != 0) root["rating"] = static_cast<std::int64_t>(info.rating);
  return root;
}

// What a data set says of its columns.
struct Columns {
  std::string unit;   // of each, or of all
  std::string about;  // the whole of it in one text
  std::vector<std::string> names;
};

// The scale of a dimension, in the folder of the demonstration: of rows, and of columns named so.
std::string scale_of(const std::vector<std::string>& names) {
  const std::string scale = names.size() == 1          ? "value"
                            : names.size() == kRawAxes ? "axis"
                            : names.size() == 5        ? names[0] == "Fx" ? "wrench" : "pose"
                            : names[0] == "tip_x"      ? "state"
                                                       : "force";
  return std::string(kDemo) + "/" + scale;
}

void add_labels(Content& content, const std::vector<std::string>& names) {
  const std::string path = scale_of(names);
  const auto known = [&](const hdf5::Labels& labels) { return labels.path == path; };
  if (std::none_of(content.labels.begin(), content.labels.end(), known))
    content.labels.push_back({path, names.size() == 1 ? std::vector<std::string>{"value"} : names});
  content.attributes[path];
}

void add(Content& content, std::uint64_t version, Table table, const Columns& columns) {
  auto& attributes = content.attributes[table.path];
  attributes["unit"] = columns.unit;
  if (version == 1) {
    attributes["columns"] = columns.about;
  } else {
    attributes["columns"] = columns.names;
    attributes["about"] = columns.about;
    // As CF has it: one unit of all that is in a data set.
    if (columns.unit.find(' ') == std::string::npos) attributes["units"] = columns.unit;
    table.scales = {kTimeScale};
    if (!table.flat) {
      table.scales.push_back(scale_of(columns.names));
      add_labels(content, columns.names);
    }
  }
  content.tables.push_back(std::move(table));
}

// What is derived from the rows for readers of the demonstration layout.
void add_derived(Content& content, std::uint64_t version, const Episode& episode,
                 const Scene& scene) {
  const Rows& rows = episode.rows;
  const auto count = rows.rows();
  const std::string demo = kDemo;
  const Matrix commands = rows.middleCols(kCommand.begin, kCommand.width);
  const Matrix actions = (commands * action_scale(scene).cwiseInverse().asDiagonal());
  Matrix rewards = Matrix::Zero(count, 1), dones = Matrix::Zero(count, 1);
  if (count > 0) {
    rewards(count - 1, 0) = episode.info.outcome == Outcome::inserted ? 1 : 0;
    dones(count - 1, 0) = 1;
  }
  add(content, version, {demo + "/actions", actions.cwiseMax(-1.0).cwiseMin(1.0)},
      {"1", "command / scale, cut to [-1, 1]", column_names(kCommand)});
  content.attributes[demo + "/actions"]["scale_m_s"] = action_scale(scene)[0];
  content.attributes[demo + "/actions"]["scale_rad_s"] = action_scale(scene)[4];
  add(content, version, {demo + "/rewards", rewards, Table::exact, true},
      {"1", "1 where the fibre is inserted", {"reward"}});
  add(content, version, {demo + "/dones", dones, Table::whole, true},
      {"1", "1 in the last row", {"done"}});

  const Matrix wrench = sensed_wrench(episode, scene).absolute;
  const double entrance = registered_entrance(scene);
  const Matrix depth = 1e3 * (entrance - rows.col(kHandPose.begin).array()).max(0.0).matrix();
  const Matrix time = rows.middleCols(kTime.begin, 1);
  for (const std::string& group : {demo + "/obs", demo + "/next_obs"}) {
    content.attributes[group];
    const auto observed = [&](const char* key, const Matrix& values, const Columns& columns) {
      const Matrix stored = values.cast<float>().cast<double>();
      add(content, version,
          {group + key, group.ends_with("next_obs") ? one_row_later(stored) : stored,
           Table::single},
          columns);
    };
    observed("/wrench_N", wrench,
             {"N N N N.m N.m", "Fx Fy Fz My Mz; in the hand's world", column_names(kHolder)});
    observed("/depth_mm", depth,
             {"mm", "of the hand past the entrance; in the hand's world", {"depth"}});
    observed("/time_s", time, {"s", "since the start", {"time"}});
  }
}

}  // namespace

std::string rows_path(const Block& b) {
  return std::string(kDemo) + (b.begin == kStates.begin ? "/" : "/rows/") + b.name;
}

Block block_of(Block block, std::uint64_t version) {
  if (version > 2) return block;
  const auto without = [](const Block& of, const std::string& last) {
    const std::string text = of.columns;
    return text.substr(0, text.size() - last.size());
  };
  static const std::string second = without(kForces, " particle"),
                           first = without(kForces, " flow particle"),
                           states = without(kStates, "; air");
  if (block.begin == kForces.begin) {
    block.width -= version == 1 ? 6 : 3;
    block.columns = version == 1 ? first.c_str() : second.c_str();
  } else if (block.begin == kStates.begin && version == 1) {
    block.width -= 1;
    block.columns = states.c_str();
  }
  return block;
}

Content content_of(const Episode& episode, const Scene& scene, std::uint64_t version) {
  const EpisodeInfo& info = episode.info;
  const auto count = static_cast<std::int64_t>(episode.rows.rows());
  Content content;
  content.attributes["/"] = root_attributes(info, scene);
  content.attributes["/"]["format_version"] = static_cast<std::int64_t>(version);
  if (version > 1) {
    content.tables.push_back(
        {kTimeScale, episode.rows.middleCols(kTime.begin, 1), Table::exact, true});
    content.attributes[kTimeScale] = {{"unit", "s"}, {"units", "s"}};
  }
  content.attributes["/data"] = {{"total", count}, {"env_args", environment(info).dump()}};
  content.attributes[kDemo] = {{"num_samples", count}};
  content.attributes[kDemo + std::string("/rows")];
  for (const Block& block : kBlocks) {
    const Block b = block_of(block, version);
    add(content, version,
        {rows_path(b), episode.rows.middleCols(b.begin, b.width), Table::exact, b.width == 1},
        {b.unit, b.columns, column_names(b)});
  }
  if (!info.mapping.empty()) {
    content.attributes[kDemo + std::string("/raw")];
    add(content, version, {kCountsPath, episode.counts.cast<double>(), Table::whole},
        {"1", "X Y Z Rx Ry Rz; of the device", {"X", "Y", "Z", "Rx", "Ry", "Rz"}});
  }
  add_derived(content, version, episode, scene);
  content.attributes["/"][kInputsHash] = inputs_sha1(content);
  return content;
}

std::string inputs_sha1(const Content& content) {
  const auto bytes = Json::to_cbor(content.attributes);
  std::string all(bytes.begin(), bytes.end());
  for (const Table& table : content.tables)
    if (table.path == rows_path(kCommand) || table.path == kCountsPath)
      all.append(reinterpret_cast<const char*>(table.values.data()),
                 static_cast<std::size_t>(table.values.size()) * sizeof(double));
  return sha1(all);
}

}  // namespace ferrule
