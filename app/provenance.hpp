// Where a result comes from: the scene and what was changed of it, seeds, what was read, version
// and command. Every verb that computes something states it, as text around its tables and as
// "provenance" in its JSON.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

// The scene that something brings along: a controller that of its demonstrations, a recording its
// own.
struct BroughtScene {
  Json document{};    // null: it brings none
  std::string how{};  // "law.json was trained on", "episodes were recorded in"
  std::string
      open{};  // why it brings none that could be taken; empty: it has nothing to do with one
};

// The scene that a verb runs in, and where it comes from.
struct ChosenScene {
  Scene scene;             // planned, where it asks for that
  std::string file{};      // that it was read from; empty: it was brought along
  std::string relation{};  // ", as law.json was trained on", ", not demo, which ..."; may be empty
  bool other = false;      // than the one that was brought along
};

// A value of a scene that is not as in the shipped scene; null: is not there.
struct SceneChange {
  std::string key;  // dotted
  Json value, shipped;
};
// What differs from the shipped scene that has most in common with it; names and remarks apart.
struct SceneChanges {
  std::string from;  // empty: no scene ships
  std::vector<SceneChange> changes;
};
SceneChanges changes_from_shipped(const Json& document);

// "demo", "demo with a = 1, b = 2", "mine (as demo but for a = 1)".
std::string scene_text(const Json& document, const SceneChanges& changes);

// Do two documents state the same scene, under whatever name?
bool same_scene(const Json& a, const Json& b);

class Provenance {
 public:
  Provenance& in(const ChosenScene& chosen);
  Provenance& seed(const std::string& of, std::uint64_t value);
  // A file, by its SHA-1. Throws FileTrouble.
  Provenance& read(const std::string& file);
  Provenance& read(const std::string& file, const std::string& sha1);
  // It was stopped before it was whole, and has no more than `what`: "312 of 1000 trials".
  Provenance& partial(const std::string& what);

  // "scene demo with ...; seed of trials 7", lines before the tables.
  std::string head() const;
  // "made by ferrule 0.1.0 ...", the line after them.
  std::string foot() const;
  Json to_json() const;
  // Names and values that are the same in all lines of a table.
  std::vector<std::pair<std::string, std::string>> columns() const;

 private:
  std::string hash_of_all() const;

  std::string scene_text_, notes_;
  Json scene_;
  std::vector<std::pair<std::string, std::uint64_t>> seeds_;
  std::vector<std::pair<std::string, std::string>> read_;
  std::string partial_;
};

// As a shell takes it, to the byte.
std::string shell_quoted(const std::string& argument);
// The same to be read, on one line.
std::string shell_word(const std::string& argument);
std::string shell_words(const std::vector<std::string>& words);
// Words of a command line without this option and its value.
std::vector<std::string> without_option(std::vector<std::string> words, const std::string& option);

// The program's command line, which Provenance states without --threads: the result does not depend
// on it.
void remember_command(const std::vector<std::string>& words);
// That command line, without the name of the program.
const std::vector<std::string>& command_words() noexcept;

}  // namespace ferrule
