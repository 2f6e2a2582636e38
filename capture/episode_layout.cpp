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
static_assert(EpisodeRows::kBlock == hdf5::kChunk);

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

using TableRows = EpisodeTables::TableRows;
using Values = EpisodeTables::Values;

// What a file says, and of each table where its numbers come from.
struct Layout {
  std::uint64_t version;
  Content content{};
  std::vector<Values> values{};

  void add(Table table, const Columns& columns, Values from);

 private:
  void add_labels(const std::vector<std::string>& names);
};

void Layout::add_labels(const std::vector<std::string>& names) {
  const std::string path = scale_of(names);
  const auto known = [&](const hdf5::Labels& labels) { return labels.path == path; };
  if (std::none_of(content.labels.begin(), content.labels.end(), known))
    content.labels.push_back({path, names.size() == 1 ? std::vector<std::string>{"value"} : names});
  content.attributes[path];
}

void Layout::add(Table table, const Columns& columns, Values from) {
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
      add_labels(columns.names);
    }
  }
  content.tables.push_back(std::move(table));
  values.push_back(std::move(from));
}

Values columns_of(const Block& b) {
  return [b](const TableRows& s) -> Matrix {
    return s.rows.topRows(s.count).middleCols(b.begin, b.width);
  };
}

// What policies are trained with: actions, rewards, dones.
void add_actions(Layout& layout, Outcome outcome, Eigen::Index count, const Scene& scene) {
  const std::string demo = kDemo;
  const Eigen::Matrix<double, 5, 1> scale = action_scale(scene);
  layout.add({demo + "/actions", 5},
             {"1", "command / scale, cut to [-1, 1]", column_names(kCommand)},
             [scale](const TableRows& s) -> Matrix {
               const Matrix commands = columns_of(kCommand)(s);
               const Matrix actions = commands * scale.cwiseInverse().asDiagonal();
               return actions.cwiseMax(-1.0).cwiseMin(1.0);
             });
  layout.content.attributes[demo + "/actions"]["scale_m_s"] = scale[0];
  layout.content.attributes[demo + "/actions"]["scale_rad_s"] = scale[4];
  const auto in_last_row = [count](double value) {
    return [count, value](const TableRows& s) -> Matrix {
      Matrix values = Matrix::Zero(s.count, 1);
      if (s.first + s.count == count) values(s.count - 1, 0) = value;
      return values;
    };
  };
  layout.add({demo + "/rewards", 1, Table::exact, true},
             {"1", "1 where the fibre is inserted", {"reward"}},
             in_last_row(outcome == Outcome::inserted ? 1 : 0));
  layout.add({demo + "/dones", 1, Table::whole, true}, {"1", "1 in the last row", {"done"}},
             in_last_row(1));
}

// What policies may see, and the same one row later.
void add_observations(Layout& layout, const Scene& scene) {
  const double entrance = registered_entrance(scene);
  for (const bool later : {false, true}) {
    const std::string group = std::string(kDemo) + (later ? "/next_obs" : "/obs");
    layout.content.attributes[group];
    const auto add = [&](const char* key, const Columns& columns,
                         const std::function<Matrix(const TableRows&)>& observed) {
      layout.add({group + key, static_cast<Eigen::Index>(columns.names.size()), Table::single},
                 columns, [later, observed](const TableRows& s) -> Matrix {
                   const Matrix all = observed(s).cast<float>().cast<double>();
                   return later ? all.bottomRows(s.count) : all.topRows(s.count);
                 });
    };
    add("/wrench_N",
        {"N N N N.m N.m", "Fx Fy Fz My Mz; in the hand's world", column_names(kHolder)},
        [](const TableRows& s) { return s.wrenches; });
    add("/depth_mm", {"mm", "of the hand past the entrance; in the hand's world", {"depth"}},
        [entrance](const TableRows& s) -> Matrix {
          return 1e3 * (entrance - s.rows.col(kHandPose.begin).array()).max(0.0).matrix();
        });
    add("/time_s", {"s", "since the start", {"time"}},
        [](const TableRows& s) -> Matrix { return s.rows.col(kTime.begin); });
  }
}

Layout layout_of(const EpisodeInfo& info, Eigen::Index rows, const Scene& scene) {
  const std::uint64_t version = info.format;
  const auto count = static_cast<std::int64_t>(rows);
  Layout layout{version};
  Content& content = layout.content;
  content.rows = rows;
  content.attributes["/"] = root_attributes(info, scene);
  content.attributes["/"]["format_version"] = static_cast<std::int64_t>(version);
  if (version > 1) {
    content.tables.push_back({kTimeScale, 1, Table::exact, true});
    layout.values.push_back(columns_of(kTime));
    content.attributes[kTimeScale] = {{"unit", "s"}, {"units", "s"}};
  }
  content.attributes["/data"] = {{"total", count}, {"env_args", environment(info).dump()}};
  content.attributes[kDemo] = {{"num_samples", count}};
  content.attributes[kDemo + std::string("/rows")];
  for (const Block& block : kBlocks) {
    const Block b = block_of(block, version);
    layout.add({rows_path(b), b.width, Table::exact, b.width == 1},
               {b.unit, about(b), column_names(b)}, columns_of(b));
  }
  if (!info.mapping.empty()) {
    content.attributes[kDemo + std::string("/raw")];
    layout.add({kCountsPath, kRawAxes, Table::whole},
               {"1", "X Y Z Rx Ry Rz; of the device", {"X", "Y", "Z", "Rx", "Ry", "Rz"}},
               [](const TableRows& s) -> Matrix { return s.counts.cast<double>(); });
  }
  add_actions(layout, info.outcome, rows, scene);
  add_observations(layout, scene);
  return layout;
}

}  // namespace

std::string rows_path(const Block& b) {
  return std::string(kDemo) + (b.begin == kStates.begin ? "/" : "/rows/") + b.name;
}

Block block_of(Block block, std::uint64_t version) {
  if (block.begin == kForces.begin && version <= 2) block.width -= version == 1 ? 6 : 3;
  if (block.begin == kStates.begin && version == 1) block.width -= 1;
  return block;
}

EpisodeTables::EpisodeTables(const EpisodeRows& rows, const Scene& scene)
    : rows_(rows), sensor_(rows.info(), scene) {
  Layout layout = layout_of(rows.info(), rows.count(), scene);
  content_ = std::move(layout.content);
  values_ = std::move(layout.values);
}

std::vector<Matrix> EpisodeTables::next() {
  std::vector<Matrix> block;
  if (next_ == rows_.count()) return block;
  const TableRows rows = next_rows();
  for (const Values& values : values_) block.push_back(values(rows));
  return block;
}

EpisodeTables::TableRows EpisodeTables::next_rows() {
  const EpisodeRows::Part& part = rows_.part_of(next_);
  TableRows s{next_, part.rows.rows(), {}, part.counts, {}};
  s.rows.resize(s.count + 1, Eigen::NoChange);
  s.rows.topRows(s.count) = part.rows;
  next_ += s.count;
  const bool last = next_ == rows_.count();
  s.rows.row(s.count) = rows_.row(last ? next_ - 1 : next_);
  s.wrenches.resize(s.count + 1, 5);
  for (Eigen::Index n = 0; n <= s.count; ++n) {
    const bool known = (n == 0 && s.first > 0) || (n == s.count && last);
    if (!known) sensor_.read(s.rows.row(n));
    s.wrenches.row(n) = sensor_.absolute().transpose();
  }
  return s;
}

std::string inputs_sha1(const Content& content,
                        const std::function<Matrix(const std::string& path, Eigen::Index first,
                                                   Eigen::Index count)>& numbers) {
  const auto attributes = Json::to_cbor(content.attributes);
  Sha1 hash;
  hash.add(attributes.data(), attributes.size());
  for (const Table& table : content.tables) {
    if (table.path != rows_path(kCommand) && table.path != kCountsPath) continue;
    for (Eigen::Index first = 0; first < content.rows; first += hdf5::kChunk) {
      const Matrix block = numbers(table.path, first, std::min(hdf5::kChunk, content.rows - first));
      hash.add(block.data(), static_cast<std::size_t>(block.size()) * sizeof(double));
    }
  }
  return hash.text();
}

}  // namespace ferrule
