// The keys of scene files, as data/scenes/scene.schema.json states them.
#pragma once

#include <string>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

struct SceneKey {
  std::string key;    // dotted
  std::string about;  // the schema's remark, or that of the object that it is in
  bool object;        // holds further keys
};

// In the order of the schema. Empty where no schema is installed.
std::vector<SceneKey> scene_keys();

// Throws BadInput where the key of a --set KEY=VALUE is none of a scene, and says which one may
// have been meant.
void refuse_unknown_key(const std::string& setting);

}  // namespace ferrule
