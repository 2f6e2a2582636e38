#include "capture/episode.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <filesystem>

#include "capture/child.hpp"
#include "capture/hdf5.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/sensed_wrench.hpp"
#include "sim/base/content_hash.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;
using hdf5::Content;
using hdf5::Matrix;
using hdf5::Reader;
using hdf5::Table;

constexpr const char* kFormat = "ferrule episode";
// 1: columns as one text, no scales, no flow and air; 2: no particle; 3 and 4: with the warm start of
// the step after. Older files are read, and held against what they were.
constexpr std::uint64_t kFormatVersion = 5;
constexpr const char* kDemo = "/data/demo_0";
constexpr const char* kCountsPath = "/data/demo_0/raw/counts";
constexpr const char* kTimeScale = "/data/demo_0/time";
constexpr const char* kInputsHash = "inputs_sha1";

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

// The texts that are there where they are not empty.
template <class Info>
auto optional_texts(Info& info) {
  return std::array{std::pair{"mapping", &info.mapping}, std::pair{"coupling", &info.coupling},
                    std::pair{"loop", &info.loop},       std::pair{"why", &info.why},
                    std::pair{"trainee", &info.trainee}, std::pair{"date", &info.date},
                    std::pair{"session", &info.session}};
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

// The hash of what cannot be computed again from the rest: all attributes, and what the hand did.
std::string inputs_sha1(const Content& content) {
  const auto bytes = Json::to_cbor(content.attributes);
  std::string all(bytes.begin(), bytes.end());
  for (const Table& table : content.tables)
    if (table.path == rows_path(kCommand) || table.path == kCountsPath)
      all.append(reinterpret_cast<const char*>(table.values.data()),
                 static_cast<std::size_t>(table.values.size()) * sizeof(double));
  return sha1(all);
}

// A block as files of a format have it: the second knew no particle, the first neither flow ahead
// of the end nor air there.
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

Content content_of(const Episode& episode, const Scene& scene,
                   std::uint64_t version = kFormatVersion) {
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

EpisodeInfo read_info(const Reader& in, const std::string& file) {
  if (!in.has("format") || in.text("format") != kFormat)
    throw FileTrouble(file + ": not a ferrule episode");
  if (const auto version = in.whole("format_version"); version < 1 || version > kFormatVersion)
    throw FileTrouble(file + ": episode format " + std::to_string(version) +
                      "; this program reads format 1 to " + std::to_string(kFormatVersion));
  EpisodeInfo info;
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
  for (const auto& [key, value] : optional_texts(info))
    if (in.has(key)) *value = in.text(key);
  if (in.has(kInputsHash)) info.inputs_sha1 = in.text(kInputsHash);
  if (in.has("rating"))
    info.rating = static_cast<int>(std::min<std::uint64_t>(in.whole("rating"), 6));
  if (info.rating > 5) throw FileTrouble(file + ": damaged: rating must be from 1 to 5");
  if (!period_rule().allows(info.period))
    throw FileTrouble(
        fmt::format("{}: damaged: period_s = {:g}: {}", file, info.period, period_rule().text));
  return info;
}

// The rows' times, one after the other: that there are as many as the file says.
Matrix read_times(const Reader& in, double period, const std::string& file) {
  Matrix times = in.table(rows_path(kTime), 1, -1).values;
  for (Eigen::Index n = 0; n < times.rows(); ++n)
    if (!(std::abs(times(n, 0) - static_cast<double>(n) * period) <= 0.5 * period))
      throw FileTrouble(fmt::format("{}: damaged: {} at row {} is {:g}, with a period of {:g} s",
                                    file, rows_path(kTime), n, times(n, 0), period));
  if (times.rows() == 0) throw FileTrouble(file + ": damaged: it holds no rows");
  return times;
}

// What a child may take: at first, and with so many rows, each of which is there.
void allow_file(const std::string& file) {
  constexpr std::size_t kMost = 512 << 20;
  const std::size_t size = fs::file_size(file);
  Child::Parent::allow(std::min(kMost, 16 * size), size >> 26);
}
void allow_rows(Eigen::Index rows) {
  const auto count = static_cast<std::size_t>(rows);
  Child::Parent::allow(8 * count * sizeof(RowVector), count / 20000);
}

Episode read_in_child(const std::string& file) {
  allow_file(file);
  const Reader in(file, "a ferrule episode");
  Episode episode;
  episode.info = read_info(in, file);
  const Matrix times = read_times(in, episode.info.period, file);
  const Eigen::Index count = times.rows();
  allow_rows(count);
  episode.rows.setZero(count, kRowSize);
  for (const Block& block : kBlocks) {
    const Block b = block_of(block, in.whole("format_version"));
    const Matrix values = in.table(rows_path(b), b.width, count).values;
    for (Eigen::Index n = 0; n < count; ++n)
      if (!values.row(n).allFinite())
        throw FileTrouble(
            fmt::format("{}: damaged: {} at row {} is not a finite number", file, rows_path(b), n));
    episode.rows.middleCols(b.begin, b.width) = values;
  }
  if (!episode.info.mapping.empty()) {
    const Matrix counts = in.table(kCountsPath, kRawAxes, count).values;
    if (counts.size() > 0 && !(counts.cwiseAbs().maxCoeff() <= INT32_MAX))
      throw FileTrouble(file + ": damaged: " + kCountsPath + " is beyond what a device counts");
    episode.counts = counts.cast<std::int32_t>();
  }
  return episode;
}

// To and from a child.
Json to_json(const EpisodeInfo& info, Eigen::Index rows) {
  return {info.scene,  info.operator_,   info.seed,    info.trial,   info.period,   info.outcome,
          info.why,    info.version,     info.build,   info.mapping, info.coupling, info.loop,
          info.rating, info.inputs_sha1, info.trainee, info.date,    info.session,  rows};
}
EpisodeInfo info_of(const Json& j) {
  EpisodeInfo info{j[0], j[1],  j[2],  j[3],  j[4],  j[5],  j[6],  j[7], j[8],
                   j[9], j[10], j[11], j[12], j[13], j[14], j[15], j[16]};
  return info;
}

void send(Child::Parent& parent, const Json& json) {
  const auto bytes = Json::to_cbor(json);
  const std::uint64_t size = bytes.size();
  parent.send(&size, sizeof size);
  parent.send(bytes.data(), bytes.size());
}
Json receive(Child& child, const std::string& file) {
  std::uint64_t size = 0;
  child.receive(&size, sizeof size);
  std::vector<std::uint8_t> bytes(std::min<std::uint64_t>(size, fs::file_size(file) + (1 << 20)));
  child.receive(bytes.data(), bytes.size());
  Json json = Json::from_cbor(bytes, true, false);
  if (json.is_discarded()) throw FileTrouble(file + ": damaged: reading it fails");
  return json;
}

// What a number or text of an attribute should be.
void compare_attribute(const std::string& key, const std::string& path, const Json& recorded,
                       const Json& expected, Verification& found) {
  const std::string column = fmt::format("attribute {} of {}", key, path);
  if (recorded == expected && recorded.is_number_float() == expected.is_number_float()) return;
  if (recorded.is_number() && expected.is_number()) {
    const double a = recorded, b = expected;
    return found.add({0, column, recorded, expected, std::abs(a - b) / std::abs(b)});
  }
  if (recorded.is_string() && expected.is_string()) {  // of JSON: where it differs
    const Json a = Json::parse(recorded.get<std::string>(), nullptr, false);
    const Json b = Json::parse(expected.get<std::string>(), nullptr, false);
    if (a.is_object() && b.is_object() && a != b) {
      const Json::json_pointer place(Json::diff(a, b).at(0).at("path").get<std::string>());
      const auto at = [&](const Json& j) { return j.contains(place) ? j.at(place) : Json(); };
      return found.add({0, column + " at " + place.to_string(), at(a), at(b)});
    }
  }
  found.add({0, column, recorded, expected});
}

void compare_attributes(const Reader& in, const Content& expected, Verification& found) {
  const auto there = in.names();
  for (const auto& [path, keys] : there) {
    const auto known = expected.attributes.find(path);
    if (known == expected.attributes.end()) found.add({0, "object " + path, path, nullptr});
    for (const std::string& key : keys)
      if (known != expected.attributes.end() && !known->second.contains(key))
        found.add(
            {0, fmt::format("attribute {} of {}", key, path), in.attribute(key, path), nullptr});
  }
  for (const auto& [path, attributes] : expected.attributes) {
    const auto known = there.find(path);
    if (known == there.end()) found.add({0, "object " + path, nullptr, path});
    for (const auto& [key, value] : attributes)
      if (known != there.end() && known->second.contains(key))
        compare_attribute(key, path, in.attribute(key, path), value, found);
      else if (known != there.end())
        found.add({0, fmt::format("attribute {} of {}", key, path), nullptr, value});
  }
}

void compare_table(const Table& recorded, const Table& expected, const std::string& units,
                   Verification& found) {
  if (recorded.stored != expected.stored || recorded.flat != expected.flat)
    found.add({0, expected.path + ": type or shape", nullptr, nullptr});
  const Eigen::RowVectorXd scale = largest_by_unit(expected.values, units);
  const auto column = [&](Eigen::Index c) { return fmt::format("{}[{}]", expected.path, c); };
  for (Eigen::Index n = 0; n < recorded.values.rows() && !found.over(); ++n)
    compare_numbers(recorded.values.row(n), expected.values.row(n), scale,
                    static_cast<std::size_t>(n), column, found);
}

// What files of formats 3 and 4 have of a warm start, which is not read.
void add_warm_start(const Reader& in, Content& expected) {
  for (const auto& [path, keys] : in.names()) {
    if (!path.ends_with("/linearization") && !path.ends_with("/tangent")) continue;
    auto& attributes = expected.attributes[path];
    for (const std::string& key : keys) attributes[key] = in.attribute(key, path);
  }
  expected.attributes["/"].erase(kInputsHash);
  expected.attributes["/"][kInputsHash] = inputs_sha1(expected);
}

Verification compare_in_child(const std::string& file, const Episode& episode, double tolerance) {
  allow_file(file);
  allow_rows(2 * episode.rows.rows());
  const Reader in(file, "a ferrule episode");
  const std::uint64_t version = in.whole("format_version");
  Content expected = content_of(episode, recorded_scene(episode, file), version);
  if (version == 3 || version == 4) add_warm_start(in, expected);
  if (episode.info.inputs_sha1.empty()) expected.attributes["/"].erase(kInputsHash);
  Verification found{tolerance, {}, {}};
  for (const Table& table : expected.tables) {
    if (found.over()) break;
    compare_table(in.table(table.path, table.values.cols(), table.values.rows()), table,
                  expected.attributes.at(table.path).at("unit"), found);
  }
  for (const hdf5::Labels& labels : expected.labels)
    if (in.labels(labels.path) != labels.texts)
      found.add({0, labels.path, in.labels(labels.path), labels.texts});
  // After the rows: a hash tells that they were changed, but not where.
  if (!found.over()) compare_attributes(in, expected, found);
  return found;
}

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

Scene recorded_scene(const Episode& episode, const std::string& file) {
  return parse_scene(parse_json(episode.info.scene, file), file);
}

void write_episode(const std::string& file, const Episode& episode, const WriteProgress& progress) {
  const Scene scene = recorded_scene(episode, file);
  write_text(file, hdf5::image(file, content_of(episode, scene), progress), false);
}

void write_episode_again(const std::string& file, const Episode& episode) {
  const Scene scene = recorded_scene(episode, file);
  write_text(file, hdf5::image(file, content_of(episode, scene), {}));
}

std::string date_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  ::gmtime_r(&now, &utc);
  std::array<char, 32> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text.data();
}

Episode read_episode(const std::string& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error))
    throw FileTrouble(file + (fs::exists(file, error) ? ": is no file" : ": no such file"));
  Child child(file, [&](Child::Parent& parent) {
    const Episode read = read_in_child(file);
    send(parent, to_json(read.info, read.rows.rows()));
    parent.send(read.rows.data(), static_cast<std::size_t>(read.rows.size()) * sizeof(double));
    parent.send(read.counts.data(),
                static_cast<std::size_t>(read.counts.size()) * sizeof(std::int32_t));
  });
  Episode episode;
  const Json info = receive(child, file);
  const auto rows = info.back().get<Eigen::Index>();
  episode.info = info_of(info);
  episode.rows.resize(rows, Eigen::NoChange);
  child.receive(episode.rows.data(),
                static_cast<std::size_t>(episode.rows.size()) * sizeof(double));
  if (!episode.info.mapping.empty()) episode.counts.resize(rows, Eigen::NoChange);
  child.receive(episode.counts.data(),
                static_cast<std::size_t>(episode.counts.size()) * sizeof(std::int32_t));
  return episode;
}

SensedRows sensed_wrench(const Episode& episode, const Scene& scene) {
  const EpisodeInfo& info = episode.info;
  SensedWrench sensed(scene_scaling(scene), ForceSensor(scene.sensor, info.seed, info.trial),
                      info.period, scene_tare(scene));
  const Eigen::Index count = episode.rows.rows();
  SensedRows all;
  all.absolute.resize(count, Eigen::NoChange);
  all.relative.resize(count, Eigen::NoChange);
  for (Eigen::Index n = 0; n < count; ++n) {
    sensed.read(episode.rows.row(n).segment<5>(kHolder.begin).transpose(),
                episode.rows(n, kStates.begin + 5));  // of the holder at the tip's scale
    all.absolute.row(n) = sensed.absolute().transpose();
    all.relative.row(n) = sensed.relative().transpose();
  }
  return all;
}

void compare_file(const std::string& file, const Episode& episode, Verification& comparison) {
  Child child(file, [&](Child::Parent& parent) {
    const Verification found = compare_in_child(file, episode, comparison.tolerance);
    Json differences = Json::array();
    for (const auto& d : {found.largest, found.first})
      if (d) differences.push_back({d->row, d->column, d->recorded, d->expected, d->relative});
    send(parent, differences);
  });
  for (const Json& d : receive(child, file)) comparison.add({d[0], d[1], d[2], d[3], d[4]});
}

std::optional<Difference> file_difference(const std::string& file, const Episode& episode) {
  Verification comparison;
  compare_file(file, episode, comparison);
  return comparison.first;
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

}  // namespace ferrule
