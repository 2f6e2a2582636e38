// The page of the operator's window (view/page/), one HTML file, and the same as a file that
// replays from disk.
#pragma once

#include <optional>
#include <string>

#include "sim/scene/json_fields.hpp"

namespace ferrule {

// The page; empty where the program was built without it (Node was missing). Throws FileTrouble if
// it is there and cannot be read.
std::optional<std::string> page_html();
// What is said where it is missing.
extern const char* const kNoPage;

// `page` with what it is to replay (view/recorded.hpp) inside, needing nothing beside it.
std::string self_contained(const std::string& page, const Json& recorded);

}  // namespace ferrule
