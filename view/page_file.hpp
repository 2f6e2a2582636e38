// The page that the window shows, one HTML file that the build makes of view/page/, and the same
// as a file that replays from disk.
#pragma once

#include <optional>
#include <string>

#include "sim/base/json_fields.hpp"

namespace ferrule {

// The text of page.html: of the share folder that the program was installed to, or else of the
// build. Empty where it was never built, because Node was missing.
std::optional<std::string> built_page();
// The same. Throws BadInput, with that as its text, where it was never built.
std::string load_page();
extern const char* const kNoPage;

// The Content-Security-Policy that `page` itself has; where it has none, one that allows nothing.
std::string policy_of(const std::string& page);
// What that policy names for `kind`, "script-src" or "style-src": 'sha256-...'; empty for none.
std::string sources_of(const std::string& page, const std::string& kind);

// `page` with what it is to replay (view/recorded.hpp) inside, needing nothing beside it; or with
// kServed, which has it ask the program for that; or with Session::first_picture, to begin with.
std::string self_contained(const std::string& page, const Json& recorded);
inline constexpr const char* kServed = "served";

}  // namespace ferrule
