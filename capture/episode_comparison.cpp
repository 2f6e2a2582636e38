// What a file has beside its rows, against what an episode of those rows has.
#include <fmt/format.h>

#include <cmath>

#include "capture/child.hpp"
#include "capture/stored_episode.hpp"

namespace ferrule {
namespace {

using hdf5::Content;
using hdf5::Matrix;
using hdf5::Reader;
using hdf5::StoredTable;

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

// The largest number of each unit in a table; for each column.
Eigen::RowVectorXd scale_of(EpisodeTables tables, std::size_t table) {
  const hdf5::Table& it = tables.content().tables[table];
  const std::string units = tables.content().attributes.at(it.path).at("unit");
  Eigen::RowVectorXd scale = Eigen::RowVectorXd::Zero(it.width);
  for (std::vector<Matrix> block; !(block = tables.next()).empty();)
    scale = scale.cwiseMax(largest_by_unit(block[table], units));
  return scale;
}

// The numbers of all tables that follow from the rows.
void compare_tables(const StoredEpisode& stored, const EpisodeTables& tables, Verification& found) {
  const auto& expected = tables.content().tables;
  std::vector<StoredTable> recorded;
  for (const hdf5::Table& table : expected) {
    recorded.push_back(stored.in().table(table.path, table.width, stored.count()));
    const hdf5::Table& it = recorded.back().table();
    if (it.stored != table.stored || it.flat != table.flat)
      found.add({0, table.path + ": type or shape", nullptr, nullptr});
  }
  std::vector<Eigen::RowVectorXd> scales(expected.size());  // of those that differ
  EpisodeTables computed = tables;
  Eigen::Index first = 0;
  for (std::vector<Matrix> block; !found.over() && !(block = computed.next()).empty();) {
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (stored.is_of_rows(expected[i].path)) continue;
      const auto column = [&](Eigen::Index c) {
        return fmt::format("{}[{}]", expected[i].path, c);
      };
      const auto scale = [&](Eigen::Index c) {
        if (scales[i].size() == 0) scales[i] = scale_of(tables, i);
        return scales[i][c];
      };
      const Matrix values = recorded[i].read(first, block[i].rows());
      for (Eigen::Index n = 0; n < values.rows() && !found.over(); ++n)
        compare_numbers(values.row(n), block[i].row(n), scale, static_cast<std::size_t>(first + n),
                        column, found);
    }
    first += block.front().rows();
  }
}

// What files of formats 3 and 4 have of a warm start, which is not read.
void add_warm_start(const Reader& in, Content& expected) {
  for (const auto& [path, keys] : in.names()) {
    if (!path.ends_with("/linearization") && !path.ends_with("/tangent")) continue;
    auto& attributes = expected.attributes[path];
    for (const std::string& key : keys) attributes[key] = in.attribute(key, path);
  }
}

Verification compare_in_child(const MappedFile& file, double tolerance) {
  const StoredEpisode stored(file);
  const EpisodeInfo& info = stored.info();
  const EpisodeRows rows = stored.rows(info);
  const EpisodeTables tables(rows, recorded_scene(info, file.name()));
  Verification found{tolerance, {}, {}};
  compare_tables(stored, tables, found);
  Content expected = tables.content();
  if (info.format == 3 || info.format == 4) add_warm_start(stored.in(), expected);
  if (!info.inputs_sha1.empty())
    expected.attributes["/"][kInputsHash] =
        inputs_sha1(expected, [&](const std::string& path, auto first, auto count) {
          return stored.numbers(path, first, count);
        });
  for (const hdf5::Labels& labels : expected.labels)
    if (stored.in().labels(labels.path) != labels.texts)
      found.add({0, labels.path, stored.in().labels(labels.path), labels.texts});
  // After the rows: a hash tells that they were changed, but not where.
  if (!found.over()) compare_attributes(stored.in(), expected, found);
  return found;
}

}  // namespace

void compare_file(const std::string& file, Verification& comparison) {
  const MappedFile bytes(file);
  Child child(file, Child::Work::reads, [&](Child::Parent& parent) {
    const Verification found = compare_in_child(bytes, comparison.tolerance);
    Json differences = Json::array();
    for (const auto& d : {found.largest, found.first})
      if (d) differences.push_back({d->row, d->column, d->recorded, d->expected, d->relative});
    parent.send_json(differences);
  });
  for (const Json& d : child.receive_json()) comparison.add({d[0], d[1], d[2], d[3], d[4]});
}

std::optional<Difference> file_difference(const std::string& file) {
  Verification comparison;
  compare_file(file, comparison);
  return comparison.first;
}

}  // namespace ferrule
