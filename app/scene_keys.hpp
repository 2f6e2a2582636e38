// What people are told of the keys of scene files (sim/scene/scene_keys.hpp).
#pragma once

#include <string>

#include "sim/scene/scene_keys.hpp"

namespace ferrule {

// What a key is: its remark, or that of the object that it is in.
std::string about(const SceneKey& key);

// Throws BadInput where the key of a --set KEY=VALUE is none of a scene, and says which one may
// have been meant.
void refuse_unknown_key(const std::string& setting);

}  // namespace ferrule
