// The keys of scene files: name, unit, range, meaning, what chance decides of them, and where a
// scene keeps their numbers. Readers, --set, `ferrule scene`, reports, draws and fits of a scene's
// numbers go by this table; data/scenes/scene.schema.json states the same for editors, as
// tests/sim/scene/scene_keys_test.cpp sees to. A new number of a scene is a new row of
// scene_key_table.cpp.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

// How chance decides a number.
struct Chance {
  bool may = true;  // in each trial, where the file states a distribution; else all have the same
  // What it is drawn from where the file does not state it; empty: nothing, in that scene.
  std::optional<Distribution> (*unless_stated)(const Scene& scene) = nullptr;
  const char* shared = "";  // as of DrawnNumber

  // May a drawn scene state it where the one that it was drawn from does not?
  bool may_add() const noexcept { return unless_stated || *shared; }
};

struct SceneKey {
  const char* name;   // dotted; its last part ends with the unit of the file
  const char* about;  // empty: as the object that it is in
  // Of a number, or of each in a list of numbers, in the unit of the file; without a text: it is an
  // object, a text, a choice or a flag.
  Rule rule{};
  double unit = 1;  // SI over the unit of the file
  // Keeps the number `x` [SI]; of a list, that at `element`. Null: nothing depends on it.
  void (*keep)(Scene& scene, double x, std::size_t element) = nullptr;
  Chance chance{};

  bool numeric() const noexcept { return !rule.text.empty(); }
};

// In the order in which they are read.
const std::vector<SceneKey>& scene_keys();

// Null: there is none of that name.
const SceneKey* find_scene_key(const std::string& name);

// The same of a number, or of an element of a list ("start.lateral_mean_um.0").
const SceneKey* scene_key_of(const std::string& number);

// Is that number stated by the scene's document?
bool states(const Scene& scene, const char* name);

// Sets a number, or an element of a list, in the unit of the file; but not what follows from it
// (resolve of read_scene.hpp). False: it is none, or not in its range.
bool set_number(Scene& scene, const std::string& key, double value);

// Reads numbers of an object of the document: keys that must be there, or where they are there.
// Throw RefusedKey.
void read_numbers(JsonFields& fields, std::initializer_list<const char*> keys, Scene& scene);
void read_numbers_if_there(JsonFields& fields, std::initializer_list<const char*> keys,
                           Scene& scene);
// A number, or a list of as many as `count`.
void read_number_or_list(JsonFields& fields, const char* key, std::size_t count,
                         const char* counted, Scene& scene);

// What chance decides unless the document states it, with the numbers that `scene` has.
std::vector<DrawnNumber> unstated_numbers(const Scene& scene);

}  // namespace ferrule
