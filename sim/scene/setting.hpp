// One value of a scene document, changed by a text: --set KEY=VALUE.
#pragma once

#include <string>

#include "sim/base/json_fields.hpp"

namespace ferrule {

// The value that a text states: JSON, and what is none is itself a text.
Json value_of(const std::string& text);

// Applies "dotted.key=value". null removes a law. A number may also be drawn per trial
// (sim/scene/distribution.hpp):
//   126+-0.3      normal, cut at 125.7 and 126.3, which are three standard deviations off
//   125.5+1/-0    uniform from 125.5 to 126.5
//   125.2..126.5  the same between these two
// A diameter takes the place of what `tolerance` says of it. Throws BadInput.
void apply_setting(Json& document, const std::string& setting);

}  // namespace ferrule
