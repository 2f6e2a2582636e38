// Scenes that state what differs from another one: "extends": "bench".
#pragma once

#include <string>
#include <vector>

#include "sim/base/json_fields.hpp"

namespace ferrule {

// A file, and what it states itself.
struct SceneLayer {
  std::string file;
  Json document;
};

// `document` of `file`, then what it extends, and so on: "extends" is the name of a scene that
// ships, or a file, with a path from the folder of the one that extends it. Throws BadInput,
// FileTrouble.
std::vector<SceneLayer> scene_layers(const Json& document, const std::string& file);

// The whole scene. Within a section (fibre, ferrule, laws, start, sensor, limits, tangent, success,
// joint, scaling) what a layer states takes the place of what it extends, key by key; a law, the
// lead-in and the holder are stated whole.
Json whole_scene(const std::vector<SceneLayer>& layers);

}  // namespace ferrule
