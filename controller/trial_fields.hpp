// What a trial's result is made of, once: the files of shards, --trials-out and Python go by it.
#pragma once

#include <array>

#include "controller/shard_files.hpp"
#include "controller/trial.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// A number of a result.
struct TrialField {
  const char *name, *unit;  // of SI; empty for a slope
  const char* told;         // its name in --trials-out, with the unit there; empty: it has none
  double scale;             // what is told = scale * value
  double& (*of)(TrialResult& result) noexcept;
};
inline constexpr std::array kTrialFields = std::to_array<TrialField>({
    {"time", "s", "time_s", 1, [](auto& r) noexcept -> double& { return r.summary.time; }},
    {"reached", "s", "", 1, [](auto& r) noexcept -> double& { return r.summary.reached; }},
    {"touched", "s", "", 1, [](auto& r) noexcept -> double& { return r.summary.touched; }},
    {"outside", "s", "", 1, [](auto& r) noexcept -> double& { return r.summary.outside; }},
    {"peak_force", "N", "peak_force_uN", 1e6,
     [](auto& r) noexcept -> double& { return r.summary.peak_force; }},
    {"peak_stress", "Pa", "", 1, [](auto& r) noexcept -> double& { return r.summary.peak_stress; }},
    {"friction_work", "J", "", 1,
     [](auto& r) noexcept -> double& { return r.summary.friction_work; }},
    {"depth", "m", "depth_um", 1e6, [](auto& r) noexcept -> double& { return r.summary.depth; }},
    {"offset", "m", "offset_um", 1e6, [](auto& r) noexcept -> double& { return r.summary.offset; }},
    {"tilt", "rad", "tilt_mrad", 1e3, [](auto& r) noexcept -> double& { return r.summary.tilt; }},
    {"tip_x", "m", "", 1, [](auto& r) noexcept -> double& { return r.summary.tip[0]; }},
    {"tip_y", "m", "", 1, [](auto& r) noexcept -> double& { return r.summary.tip[1]; }},
    {"tip_z", "m", "", 1, [](auto& r) noexcept -> double& { return r.summary.tip[2]; }},
    {"tip_tilt_y", "rad", "", 1, [](auto& r) noexcept -> double& { return r.summary.tip[3]; }},
    {"tip_tilt_z", "rad", "", 1, [](auto& r) noexcept -> double& { return r.summary.tip[4]; }},
    {"loss", "dB", "loss_dB", 1, [](auto& r) noexcept -> double& { return r.loss_dB; }},
    {"light_offset_y", "m", "", 1, [](auto& r) noexcept -> double& { return r.light.offset[0]; }},
    {"light_offset_z", "m", "", 1, [](auto& r) noexcept -> double& { return r.light.offset[1]; }},
    {"light_slope_y", "", "", 1, [](auto& r) noexcept -> double& { return r.light.slope[0]; }},
    {"light_slope_z", "", "", 1, [](auto& r) noexcept -> double& { return r.light.slope[1]; }},
});
double value(const TrialField& field, const TrialResult& result) noexcept;

// As shards keep it: every bit of it, by the names of its fields.
Json kept_trial(const TrialResult& result);
// Throws Json::exception where it is not a result.
TrialResult trial_of(const KeptTrial& kept);

// As --trials-out tells it: outcome, why it failed, the numbers that have a name there, null where
// they are not finite, and with a supervisor what that did.
Json told_trial(const TrialResult& result);

}  // namespace ferrule
