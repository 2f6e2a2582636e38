// What an unknown name may have been meant for: messages say it.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace ferrule {

// The one of `known` that is nearest to `name` by Levenshtein's distance, where one that begins
// with `name` is at 1. Empty: none is within a third of the longer one's letters, or within 2.
std::string nearest(const std::string& name, const std::vector<std::string>& known);

// ": did you mean X?", with the nearest; empty where none is near.
std::string did_you_mean(const std::string& name, const std::vector<std::string>& known);

// What is wrong with the dotted key that has `value`, where there is no such key but `meant`: where
// they differ in the unit alone (diameter_mm and diameter_um), with the value in the unit of that.
std::string unknown_key(const std::string& key, const nlohmann::json& value,
                        const std::string& meant);

}  // namespace ferrule
