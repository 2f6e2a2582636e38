// A campaign's summary for people and as JSON.
#pragma once

#include "controller/campaign.hpp"
#include "controller/supervisor.hpp"
#include "sim/base/json_fields.hpp"

namespace ferrule {

// controller/README.md describes the keys.
Json to_json(const CampaignSummary& summary);
void add_json(const WorstTenth& worst, Json& json);
void add_json(const Comparison& comparison, Json& json);
std::string to_text(const std::string& name, const CampaignSummary& summary);
std::string to_text(const Comparison& comparison);
// "99.9 % shown after 4512 trials".
std::string to_text(const Verdict& verdict);

// " (B to C)": the grades that the intervals allow (mated_pairs.hpp), where there are several.
std::string allowed_grades_text(const MatedPairs& pairs);

// Further trials that would show `rate` at the success rate so far (trials_to_show), or `otherwise`
// where none would.
std::string trials_to_show_or(const char* otherwise, double rate, const CampaignSummary& summary);

// Says where the time limit ended most of the trials that failed; otherwise nothing.
std::string time_limit_note(std::size_t timeouts, std::size_t failures);
std::string time_limit_note(const CampaignSummary& summary);

// Appends one row for each trial of a controller, with what chance decided in it: what --trials-out
// holds.
void add_trials(const std::string& controller, const std::vector<TrialResult>& results,
                const std::vector<DrawnQuantity>& drawn, Json& rows);

// What the supervisor of a scene keeps; and what it says where it cannot hold the force limit.
Json supervisor_json(const SupervisorLimits& limits, const Scaling& scaling);
std::string supervisor_note(const SupervisorLimits& limits);

}  // namespace ferrule
