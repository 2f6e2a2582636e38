#include "sim/scene/scene_keys.hpp"

#include <algorithm>
#include <unordered_map>

namespace ferrule {
namespace {

std::string last_part(const std::string& key) {
  return key.substr(key.rfind('.') + 1);  // npos + 1 is 0
}

// A row, and which element of its list.
struct Place {
  const SceneKey* row;  // null: there is none
  std::size_t element = 0;
};

Place place_of(const std::string& key) {
  if (const SceneKey* row = find_scene_key(key)) return {row};
  const std::string element = last_part(key);
  if (element.size() == key.size() || element.size() > 3 ||
      element.find_first_not_of("0123456789") != element.npos)
    return {nullptr};
  return {find_scene_key(key.substr(0, key.size() - element.size() - 1)), std::stoul(element)};
}

// Reads a number of its row, and notes that it is stated.
void keep(const SceneKey& row, double value, std::size_t element, Scene& scene) {
  scene.states.set(static_cast<std::size_t>(&row - scene_keys().data()));
  if (row.keep) row.keep(scene, row.unit * value, element);
}

const SceneKey& row_of(const JsonFields& fields, const char* key) {
  return *find_scene_key(fields.path(key));
}

}  // namespace

const SceneKey* find_scene_key(const std::string& name) {
  static const auto rows = [] {
    std::unordered_map<std::string_view, const SceneKey*> by_name;
    for (const SceneKey& row : scene_keys()) by_name.emplace(row.name, &row);
    return by_name;
  }();
  const auto found = rows.find(name);
  return found == rows.end() ? nullptr : found->second;
}

bool states(const Scene& scene, const char* name) {
  return scene.states[static_cast<std::size_t>(find_scene_key(name) - scene_keys().data())];
}

const SceneKey* scene_key_of(const std::string& number) {
  return place_of(number).row;
}

bool set_number(Scene& scene, const std::string& key, double value) {
  const Place place = place_of(key);
  if (!place.row || !place.row->numeric() || !place.row->rule.allows(value)) return false;
  if (place.row->keep) place.row->keep(scene, place.row->unit * value, place.element);
  return true;
}

void read_numbers(JsonFields& fields, std::initializer_list<const char*> keys, Scene& scene) {
  for (const char* key : keys) {
    const SceneKey& row = row_of(fields, key);
    keep(row, fields.number(key, row.rule), 0, scene);
  }
}

void read_numbers_if_there(JsonFields& fields, std::initializer_list<const char*> keys,
                           Scene& scene) {
  for (const char* key : keys)
    if (fields.present(key)) read_numbers(fields, {key}, scene);
}

void read_number_or_list(JsonFields& fields, const char* key, std::size_t count,
                         const char* counted, Scene& scene) {
  const Json& stated = fields.raw(key);
  if (!stated.is_array()) return read_numbers(fields, {key}, scene);
  const SceneKey& row = row_of(fields, key);
  const bool numbers = std::all_of(stated.begin(), stated.end(), [&](const Json& each) {
    return each.is_number() && row.rule.allows(each.get<double>());
  });
  if (!numbers || stated.empty())
    fields.refuse(key, "must be a number, or a list of numbers; each " + row.rule.text);
  if (stated.size() != count)
    fields.refuse(key, "must be one number, or as many as " + std::string(counted) +
                           " has: " + std::to_string(count));
  for (std::size_t i = 0; i < count; ++i) keep(row, stated[i].get<double>(), i, scene);
}

std::vector<DrawnNumber> unstated_numbers(const Scene& scene) {
  std::vector<DrawnNumber> numbers;
  for (const SceneKey& row : scene_keys())
    if (row.chance.unless_stated && !states(scene, row.name))
      if (const auto distribution = row.chance.unless_stated(scene))
        numbers.push_back({row.name, *distribution, true, row.chance.shared});
  return numbers;
}

}  // namespace ferrule
