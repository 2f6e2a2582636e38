// Reads the sections of a scene file: which keys must be there, and which go together. What each
// number is, and where it goes, is a row of scene_keys.hpp; what chance decides, and files, are in
// scene.cpp.
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

// Sets what follows from the numbers of a scene: its world, and what a tangent may be off by where
// that is not stated. Where the numbers cannot be together it says which.
std::optional<Inconsistency> resolve(Scene& scene);

}  // namespace ferrule
