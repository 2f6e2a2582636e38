// What a result of evaluate, compare, sweep, map or sensitivity answers, in words: from its JSON.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "sim/base/json_fields.hpp"

namespace ferrule {

struct Answer {
  std::string question;
  std::vector<std::string> lines;  // the answer, how long and which grade, at which confidence
};

// By verb, of its result; the rows of evaluate and compare as short_row of varied_scene.hpp makes
// them. They throw what reading JSON throws where it has no such keys.
const std::map<std::string, Answer (*)(const Json&)>& answers();

// Which row of a sweep or a comparison it is: "bore diameter 126 um, force limit 80 uN".
std::string row_in_words(const Json& result, const Json& row);

// "bore diameter", "um" of "ferrule.bore_diameter_um"; the unit may be empty.
struct KeyInWords {
  std::string name, unit;
};
KeyInWords in_words(const std::string& key);
// "bore diameter 125.5..126.5 um".
std::string in_words(const std::string& key, const Json& value);
// What ended the trials that failed, the most frequent first: "force limit 143 of 200, ...".
std::string failures_in_words(const Json& outcomes);

}  // namespace ferrule
