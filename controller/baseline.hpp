// Controllers without demonstrations and without a file, each by its name: what others are measured
// against.
#pragma once

#include <string>
#include <vector>

#include "controller/trial.hpp"

namespace ferrule {

inline constexpr const char *kStraight = "constant-velocity", *kSpiral = "spiral",
                            *kSearching = "searching-operator";
const std::vector<std::string>& baseline_names();
// Of that name, where no file of the folder has it.
bool is_baseline(const std::string& name);

// The controllers that these names mean in trials of `scene` under `seed`: straight in at constant
// velocity, as fast as the scene lets it; a blind spiral (controller/blind_spiral.hpp); an operator
// of skill 0.8 who finds the bore by touch (controller/searching_operator.hpp). Throws BadInput
// where he does not know the scene's scaling.
MakeController baseline(const std::string& name, const Scene& scene, std::uint64_t seed);

}  // namespace ferrule
