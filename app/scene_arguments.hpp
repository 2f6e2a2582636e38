// The scene that a verb is given: --scene and --set.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "app/provenance.hpp"

namespace ferrule {

// --scene NAME|FILE and --set dotted.key=value. One rule for all verbs: a controller or a recording
// brings its scene along, --scene takes another, and where there is neither it is `demo`.
struct SceneArguments {
  std::string scene;  // empty: not given
  std::vector<std::string> settings;

  // `unless_given`: which one it is then, for the help.
  void add_to(CLI::App& verb, const std::string& unless_given = "demo");
  std::string name() const { return scene.empty() ? "demo" : scene; }
  // As they were given, for a command that is shown: each after a space.
  std::string given() const;
  // What --scene and --set say alone, not planned. Throws BadInput, FileTrouble.
  Scene load() const;
  // Throws BadInput, FileTrouble.
  ChosenScene choose(const BroughtScene& brought = {}) const;
};

// `scene`, or where it states an accuracy the planned one, with progress. Throws Stopped.
Scene planned_with_progress(const Scene& scene);

}  // namespace ferrule
