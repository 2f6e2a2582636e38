// Files of strangers are read and compared in a child process with limits.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "capture/child.hpp"
#include "capture/episode_layout.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;
using hdf5::Content;
using hdf5::Matrix;
using hdf5::Reader;
using hdf5::Table;

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

}  // namespace ferrule
