#include "controller/kept_trial.hpp"

namespace ferrule {
namespace {

template <class Numbers>
Json list(const Numbers& numbers) {
  Json all = Json::array();
  for (const double x : numbers) all.push_back(x);
  return all;
}

template <class Numbers>
void read_list(const Json& all, Numbers& numbers) {
  std::size_t i = 0;
  for (auto& x : numbers) x = all.at(i++);
}

// The numbers of a summary, in their order.
template <class Summary, class Each>
void each_number(Summary& s, const Each& each) {
  for (auto* x : {&s.time, &s.reached, &s.touched, &s.outside, &s.peak_force, &s.peak_stress,
                  &s.friction_work, &s.depth, &s.offset, &s.tilt})
    each(*x);
  for (auto& x : s.tip) each(x);
}

Json to_json(const Supervision& supervision) {
  const auto why = supervision.gave_up;
  return {supervision.interventions, why ? Json(static_cast<int>(*why)) : Json()};
}

// One of an enum of so many.
template <class Enum>
Enum one_of(const Json& json, std::int64_t count) {
  const auto number = json.get<std::int64_t>();
  if (number < 0 || number >= count) throw Json::out_of_range::create(401, "unknown", &json);
  return static_cast<Enum>(number);
}

Supervision supervision_of(const Json& json) {
  Supervision s;
  s.interventions = json.at(0);
  if (!json.at(1).is_null()) s.gave_up = one_of<Intervention>(json.at(1), kInterventions);
  return s;
}

}  // namespace

Json kept_trial(const TrialResult& r) {
  Json numbers = Json::array();
  each_number(r.summary, [&](double x) { numbers.push_back(x); });
  return {static_cast<int>(r.outcome),
          std::move(numbers),
          r.summary.steps,
          r.summary.unfinished,
          r.loss_dB,
          list(r.light.offset),
          list(r.light.slope),
          r.why,
          r.supervision ? to_json(*r.supervision) : Json()};
}

TrialResult trial_of(const Json& json) {
  TrialResult r{};
  r.outcome = one_of<Outcome>(json.at(0), kOutcomes);
  std::size_t i = 0;
  each_number(r.summary, [&](double& x) { x = json.at(1).at(i++); });
  r.summary.steps = json.at(2);
  r.summary.unfinished = json.at(3);
  r.loss_dB = json.at(4);
  read_list(json.at(5), r.light.offset);
  read_list(json.at(6), r.light.slope);
  r.why = json.at(7);
  if (!json.at(8).is_null()) r.supervision = supervision_of(json.at(8));
  return r;
}

}  // namespace ferrule
