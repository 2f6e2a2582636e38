#include "app/scene_keys.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "sim/base/unknown_name.hpp"
#include "sim/scene/setting.hpp"

namespace ferrule {
namespace {

// The keys of one object of the schema, those of its alternatives too.
void add_keys(const Json& schema, const Json& object, const std::string& path,
              const std::string& about, std::vector<SceneKey>& keys) {
  if (object.contains("$ref")) {
    const std::string reference = object["$ref"];  // "#/..."
    if (reference == "#/$defs/drawn") return;      // any number may be
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

std::string last_name(const std::string& key) {
  return key.substr(key.rfind('.') + 1);  // npos + 1 is 0
}

// By the whole key, or by its last name alone: some write "bore_diameter". Empty: none is near.
std::string closest(const std::string& key, const std::vector<SceneKey>& keys) {
  std::vector<std::string> whole, last;
  for (const SceneKey& k : keys) {
    whole.push_back(k.key);
    last.push_back(last_name(k.key));
  }
  std::string near = nearest(key, whole);
  const std::string named = nearest(last_name(key), last);
  if (!near.empty() || named.empty()) return near;
  return whole[static_cast<std::size_t>(std::find(last.begin(), last.end(), named) - last.begin())];
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
  const std::string meant = closest(key, keys);
  const std::string value = setting.substr(key.size() + 1);
  const std::string why = meant.empty() ? "unknown key" : unknown_key(key, value_of(value), meant);
  throw BadInput("--set " + key + " = " + value + ": " + why + " (\"ferrule scene\" lists all)");
}

}  // namespace ferrule
