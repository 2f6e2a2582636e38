#include "app/scene_keys.hpp"

#include <algorithm>

#include "sim/base/unknown_name.hpp"
#include "sim/scene/setting.hpp"

namespace ferrule {
namespace {

std::string last_name(const std::string& key) {
  return key.substr(key.rfind('.') + 1);  // npos + 1 is 0
}

// By the whole key, or by its last name alone: some write "bore_diameter". Empty: none is near.
std::string closest(const std::string& key) {
  std::vector<std::string> whole, last;
  for (const SceneKey& k : scene_keys()) {
    whole.emplace_back(k.name);
    last.push_back(last_name(k.name));
  }
  std::string near = nearest(key, whole);
  const std::string named = nearest(last_name(key), last);
  if (!near.empty() || named.empty()) return near;
  return whole[static_cast<std::size_t>(std::find(last.begin(), last.end(), named) - last.begin())];
}

}  // namespace

std::string about(const SceneKey& key) {
  const std::string name = key.name;
  const auto dot = name.rfind('.');
  return *key.about || dot == name.npos ? key.about : about(*find_scene_key(name.substr(0, dot)));
}

void refuse_unknown_key(const std::string& setting) {
  const std::string key = setting.substr(0, setting.find('='));
  if (key.empty() || key.size() > 200 || key.size() == setting.size()) return;  // said elsewhere
  if (find_scene_key(key)) return;
  const std::string meant = closest(key);
  const std::string value = setting.substr(key.size() + 1);
  const std::string why = meant.empty() ? "unknown key" : unknown_key(key, value_of(value), meant);
  throw BadInput("--set " + key + " = " + value + ": " + why + " (\"ferrule scene\" lists all)");
}

}  // namespace ferrule
