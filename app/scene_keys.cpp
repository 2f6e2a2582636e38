#include "app/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <numeric>
#include <optional>

namespace ferrule {
namespace {

// The keys of one object of the schema, those of its alternatives too.
void add_keys(const Json& schema, const Json& object, const std::string& path,
              const std::string& about, std::vector<SceneKey>& keys) {
  if (object.contains("$ref")) {
    const std::string reference = object["$ref"];  // "#/..."
    add_keys(schema, schema.at(Json::json_pointer(reference.substr(1))), path, about, keys);
    return;
  }
  for (const char* alternatives : {"oneOf", "anyOf", "allOf"})
    if (object.contains(alternatives))
      for (const Json& each : object[alternatives]) add_keys(schema, each, path, about, keys);
  if (!object.contains("properties")) return;
  for (const auto& item : object["properties"].items()) {
    const std::string key = path.empty() ? item.key() : path + "." + item.key();
    if (key == "drawn_from") continue;  // recordings state it; it changes nothing
    const std::string told = item.value().value("description", about);
    const bool known =
        std::any_of(keys.begin(), keys.end(), [&](const SceneKey& k) { return k.key == key; });
    const std::size_t place = keys.size();
    if (!known) keys.push_back({key, told, false});
    add_keys(schema, item.value(), key, told, keys);
    if (!known) keys[place].object = keys.size() > place + 1;
  }
}

// Levenshtein's distance.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t exchanged = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({exchanged, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

std::string last_name(const std::string& key) {
  return key.substr(key.rfind('.') + 1);  // npos + 1 is 0
}

// By the whole key, or by its last name alone: some write "bore_diameter".
std::string closest(const std::string& key, const std::vector<SceneKey>& keys) {
  const auto far = [&](const SceneKey& k) {
    const std::string mine = last_name(key), its = last_name(k.key);
    return std::min(2 * distance(key, k.key),
                    (its.starts_with(mine) ? 1 : 2 * distance(mine, its)) + 1);
  };
  return std::min_element(keys.begin(), keys.end(),
                          [&](const SceneKey& a, const SceneKey& b) {
                            return std::pair(far(a), distance(key, a.key)) <
                                   std::pair(far(b), distance(key, b.key));
                          })
      ->key;
}

std::optional<double> number(const std::string& text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size())
    return std::nullopt;
  return value;
}

}  // namespace

std::vector<SceneKey> scene_keys() {
  const std::vector<std::string> shipped = shipped_scenes();
  if (shipped.empty()) return {};
  const auto file =
      std::filesystem::path(scene_file(shipped.front())).parent_path() / "scene.schema.json";
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return {};
  const Json schema = parse_json(read_text(file.string()), file.string());
  std::vector<SceneKey> keys;
  add_keys(schema, schema, "", "", keys);
  return keys;
}

void refuse_unknown_key(const std::string& setting) {
  const std::string key = setting.substr(0, setting.find('='));
  if (key.empty() || key.size() > 200 || key.size() == setting.size()) return;  // said elsewhere
  const std::vector<SceneKey> keys = scene_keys();
  const auto same = [&](const SceneKey& k) { return k.key == key; };
  if (keys.empty() || std::any_of(keys.begin(), keys.end(), same)) return;
  throw BadInput("--set " + key + " = " + setting.substr(key.size() + 1) +
                 ": unknown key; did you mean " + closest(key, keys) +
                 "? (\"ferrule scene\" lists all)");
}

void apply_with_tolerance(Json& document, const std::string& setting) {
  const auto equals = setting.find('='), sign = setting.find("+-");
  const std::string key = setting.substr(0, equals);
  const bool fibre = key == "fibre.diameter_um", bore = key == "ferrule.bore_diameter_um";
  if (equals == setting.npos || sign == setting.npos || sign < equals) {
    // Parts that are drawn are drawn from the tolerance: a bore beside it would say nothing.
    if (bore && document.contains("tolerance") && !document["tolerance"].is_null())
      throw BadInput("--set " + setting +
                     ": the scene draws its bores from tolerance.bore_diameter_um; set that, or a "
                     "tolerance as 126+-0.5, or tolerance=null before it");
    return apply_setting(document, setting);
  }
  const auto nominal = number(setting.substr(equals + 1, sign - equals - 1));
  const auto half = number(setting.substr(sign + 2));
  if (!(fibre || bore) || !nominal || !half || !(*half >= 0))
    throw BadInput(
        "--set " + setting +
        ": a tolerance is fibre.diameter_um or ferrule.bore_diameter_um = NUMBER+-NUMBER");
  apply_setting(document, fmt::format("{}={}", key, *nominal));
  Json& tolerance = document["tolerance"];
  if (!tolerance.is_object()) {
    const Json width = document["ferrule"]["bore_diameter_um"];
    tolerance = {{"fibre_diameter_sd_um", 0}, {"bore_diameter_um", {width, width}}};
  }
  if (fibre) tolerance["fibre_diameter_sd_um"] = *half / 3;
  if (bore) tolerance["bore_diameter_um"] = {*nominal - *half, *nominal + *half};
}

}  // namespace ferrule
