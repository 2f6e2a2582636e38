#include "controller/trial_fields.hpp"

#include <string_view>

namespace ferrule {
namespace {

// Of the `count` values of an enum the one of that name.
template <class Enum>
Enum named(const Json& text, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (text.get_ref<const std::string&>() == name(static_cast<Enum>(i)))
      return static_cast<Enum>(i);
  throw Json::out_of_range::create(401, "unknown", &text);
}

Json interventions(const Supervision& supervision) {
  Json counts;
  for (std::size_t i = 0; i < kInterventions; ++i)
    counts[kInterventionNames[i]] = supervision.interventions[i];
  return counts;
}

Json gave_up(const Supervision& supervision) {
  return supervision.gave_up ? Json(name(*supervision.gave_up)) : Json();
}

}  // namespace

double value(const TrialField& field, const TrialResult& result) noexcept {
  return field.of(const_cast<TrialResult&>(result));
}

Json kept_trial(const TrialResult& result) {
  Json kept = {{"outcome", name(result.outcome)},
               {"why", result.why},
               {"steps", result.summary.steps},
               {"unfinished", result.summary.unfinished},
               {"interventions", result.supervision ? interventions(*result.supervision) : Json()},
               {"gave_up", result.supervision ? gave_up(*result.supervision) : Json()}};
  for (const TrialField& field : kTrialFields) kept[field.name] = value(field, result);
  return kept;
}

TrialResult trial_of(const KeptTrial& kept) {
  TrialResult result{};
  result.outcome = named<Outcome>(kept["outcome"], kOutcomes);
  result.why = kept["why"];
  result.summary.steps = kept["steps"];
  result.summary.unfinished = kept["unfinished"];
  for (const TrialField& field : kTrialFields) field.of(result) = kept[field.name];
  const Json& counts = kept["interventions"];
  if (counts.is_null()) return result;
  Supervision& supervision = result.supervision.emplace();
  for (std::size_t i = 0; i < kInterventions; ++i)
    supervision.interventions[i] = counts.at(kInterventionNames[i]);
  if (const Json& why = kept["gave_up"]; !why.is_null())
    supervision.gave_up = named<Intervention>(why, kInterventions);
  return result;
}

Json told_trial(const TrialResult& result) {
  Json told = {{"outcome", name(result.outcome)}, {"why", result.why}};
  for (const TrialField& field : kTrialFields)
    if (*field.told) told[field.told] = number_or_null(field.scale * value(field, result));
  if (!result.supervision) return told;
  told["interventions"] = interventions(*result.supervision);
  told["gave_up"] = gave_up(*result.supervision);
  return told;
}

}  // namespace ferrule
