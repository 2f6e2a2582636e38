// A campaign's summary for people and as JSON.
#pragma once

#include "controller/campaign.hpp"
#include "sim/scene/json_fields.hpp"

namespace ferrule {

// controller/README.md describes the keys.
Json to_json(const CampaignSummary& summary);
void add_json(const Comparison& comparison, Json& json);
std::string to_text(const std::string& name, const CampaignSummary& summary);
std::string to_text(const Comparison& comparison);

}  // namespace ferrule
