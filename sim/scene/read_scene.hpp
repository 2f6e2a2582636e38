// The keys of a scene file: name, unit, range, and where each number goes. What chance decides, and
// files, are in scene.cpp.
#pragma once

#include <optional>

#include "sim/base/json_fields.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// Reads all keys of a document without distributions, but not the world that follows of them.
// Throws RefusedKey.
void read_scene(JsonFields& fields, const Json& document, Scene& scene);

// Which of its numbers, each in its range, cannot be together; empty: none.
std::optional<Inconsistency> inconsistency(const Scene& scene);

}  // namespace ferrule
