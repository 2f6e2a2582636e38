// One value of a scene document, changed by a text: --set KEY=VALUE.
#pragma once

#include <string>

#include "sim/base/json_fields.hpp"

namespace ferrule {

// The value that a text states: JSON, and what is none is itself a text.
Json value_of(const std::string& text);

// Applies "dotted.key=value". null removes a law. A diameter, fibre.diameter_um or
// ferrule.bore_diameter_um, may have a tolerance, which it is then drawn within (key "tolerance"):
//   126+-0.3      from 125.7 to 126.3: the bore uniform, the fibre normal, with 0.3 three standard
//                 deviations
//   125.5+1/-0    uniform from 125.5 to 126.5; the key itself is the middle
//   125.2..126.5  the same between these two
// Throws BadInput.
void apply_setting(Json& document, const std::string& setting);

}  // namespace ferrule
