// A trial's result as shards keep it (controller/shared_trials.hpp): every bit of it.
#pragma once

#include "controller/trial.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

Json kept_trial(const TrialResult& result);
// Throws Json::exception where it is no result.
TrialResult trial_of(const Json& kept);

}  // namespace ferrule
