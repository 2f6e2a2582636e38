#include "controller/campaign_table.hpp"

#include <fmt/format.h>

#include <cmath>

#include "controller/trial_fields.hpp"

namespace ferrule {
namespace {

Json spread_json(const Spread& s, double unit) {
  return {{"median", number_or_null(unit * s.median)}, {"p95", number_or_null(unit * s.p95)}};
}

Json losses_json(const MatedPairs& m) {
  return {{"mean_dB", number_or_null(m.mean_dB)},
          {"mean_low_dB", number_or_null(m.mean_95.low)},
          {"mean_high_dB", number_or_null(m.mean_95.high)},
          {"p97_dB", number_or_null(m.p97_dB)},
          {"p97_low_dB", number_or_null(m.p97_95.low)},
          {"p97_high_dB", number_or_null(m.p97_95.high)}};
}

// What holds at all wavelengths, and what each has.
Json to_json(const MatedPairs& m, const std::vector<MatedPairs>& at, const GradedJoint& joint) {
  const auto grade = [](const char* name) { return name ? Json(name) : Json(); };
  Json json = losses_json(m);
  json["pairs"] = m.pairs;
  json["grade"] = grade(connector_grade(m));
  const std::vector<const char*> allowed = allowed_grades(m);
  json["grade_best"] = allowed.empty() ? Json() : grade(allowed.front());
  json["grade_worst"] = allowed.empty() ? Json() : grade(allowed.back());
  for (std::size_t i = 0; i < at.size(); ++i)
    json["at"][fmt::format("{:.5g}_nm", 1e9 * joint.at[i].wavelength)] = losses_json(at[i]);
  return json;
}

Json to_json(const InterventionSummary& s) {
  Json kinds = Json::object(), gave_up = Json::object();
  for (std::size_t i = 0; i < kInterventions; ++i) {
    kinds[kInterventionNames[i]] = {{"count", s.kinds[i].count}, {"trials", s.kinds[i].trials}};
    gave_up[kInterventionNames[i]] = s.gave_up[i];
  }
  return {{"interventions", kinds}, {"trials_with_interventions", s.trials}, {"gave_up", gave_up}};
}

}  // namespace

Json to_json(const CampaignSummary& s) {
  Json outcomes = Json::object();
  for (int i = 0; i < kOutcomes; ++i)
    outcomes[name(static_cast<Outcome>(i))] = s.outcomes[static_cast<std::size_t>(i)];
  const auto to_show = [&](double rate) {
    const auto trials = trials_to_show(rate, s.successes, s.feasible);
    return trials ? Json(*trials) : Json();
  };
  Json json = {{"trials", s.trials},
               {"feasible", s.feasible},
               {"successes", s.successes},
               {"success_rate", number_or_null(s.success_rate)},
               {"wilson_low", s.wilson.low},
               {"wilson_high", s.wilson.high},
               {"trials_to_show_99", to_show(0.99)},
               {"trials_to_show_99_9", to_show(0.999)},
               {"outcomes", outcomes},
               {"time_limit_decides", !time_limit_note(s).empty()},
               {"time_s", spread_json(s.time, 1)},
               {"peak_force_uN", spread_json(s.peak_force, 1e6)},
               {"loss_dB", spread_json(s.loss_dB, 1)},
               {"steps", s.steps},
               {"unfinished_steps", s.unfinished}};
  if (s.target)
    json["target"] = {
        {"rate", s.target->rate}, {"verdict", name(s.target->kind)}, {"trials", s.target->trials}};
  if (s.mated) {
    const Mated& m = *s.mated;
    json["mated"] = to_json(m.untuned, m.untuned_at, m.joint);
    json["mated_tuned"] = to_json(m.tuned, m.tuned_at, m.joint);
    json["mated_joint"] = to_json(m.joint);
  }
  if (s.worst) add_json(*s.worst, json);
  if (s.interventions) json.update(to_json(*s.interventions));
  return json;
}

void add_json(const WorstTenth& worst, Json& json) {
  const Interval interval = worst.interval();
  json["worst_tenth"] = number_or_null(worst.rate());
  json["worst_tenth_of"] = {{"key", worst.name.empty() ? Json() : Json(worst.name)},
                            {"low", number_or_null(worst.low)},
                            {"high", number_or_null(worst.high)},
                            {"trials", worst.trials},
                            {"wilson_low", interval.low},
                            {"wilson_high", interval.high}};
}

void add_json(const Comparison& c, Json& json) {
  json["difference"] = number_or_null(c.difference);
  json["difference_low"] = number_or_null(c.interval.low);
  json["difference_high"] = number_or_null(c.interval.high);
  json["mcnemar_p"] = number_or_null(c.mcnemar_p);
  const auto paired = [](const PairedMedian& p, double unit) {
    return Json{{"median", number_or_null(unit * p.median)},
                {"low", number_or_null(unit * p.interval.low)},
                {"high", number_or_null(unit * p.interval.high)}};
  };
  json["time_difference_s"] = paired(c.time, 1);
  json["peak_force_difference_uN"] = paired(c.peak_force, 1e6);
}

namespace {

// Told where the trials that did not choose the tenth show that it is worse than all.
std::string to_text(const WorstTenth& worst, double rate_of_all) {
  if (!(worst.interval().high < rate_of_all)) return "";
  return fmt::format("  {:<14} where {} is {:.4g} to {:.4g}: {} of {} inserted\n", "fails most",
                     worst.name, worst.low, worst.high, worst.successes, worst.trials);
}

// "99 %: 381 more trials without a failure; 99.9 %: ..."
std::string to_show_text(const CampaignSummary& s) {
  const auto text = [&](double rate) -> std::string {
    const auto trials = trials_to_show(rate, s.successes, s.feasible);
    return !trials                     ? "not reachable at this rate"
           : *trials == 0              ? "shown"
           : s.successes == s.feasible ? fmt::format("{} more trials without a failure", *trials)
                                       : fmt::format("about {} more trials at this rate", *trials);
  };
  const std::string one = text(0.99), other = text(0.999);
  return one == other ? "99 % and 99.9 %: " + one : "99 %: " + one + "; 99.9 %: " + other;
}

}  // namespace

std::string trials_to_show_or(const char* otherwise, double rate, const CampaignSummary& summary) {
  const auto trials = trials_to_show(rate, summary.successes, summary.feasible);
  return trials ? std::to_string(*trials) : otherwise;
}

std::string to_text(const Verdict& v) {
  return fmt::format("{:.6g} % {} after {} trials", 100 * v.rate, name(v.kind), v.trials);
}

std::string time_limit_note(std::size_t timeouts, std::size_t failures) {
  if (2 * timeouts <= failures) return "";
  return fmt::format("the time limit (limits.time_s) ended {} of {} failures", timeouts, failures);
}

std::string time_limit_note(const CampaignSummary& s) {
  return time_limit_note(s.outcomes[static_cast<std::size_t>(Outcome::timeout)],
                         s.feasible - s.successes);
}

std::string allowed_grades_text(const MatedPairs& pairs) {
  const auto word = [](const char* grade) { return grade ? grade : "none"; };
  const std::vector<const char*> allowed = allowed_grades(pairs);
  if (allowed.size() < 2) return "";
  return fmt::format(" ({} to {})", word(allowed.front()), word(allowed.back()));
}

namespace {

// Of connectors as they come, or tuned.
std::string to_text(const char* how, const MatedPairs& m) {
  const auto interval = [](const Interval& of) {
    if (std::isnan(of.low)) return std::string();
    return std::isfinite(of.high) ? fmt::format(" ({:.3g} to {:.3g})", of.low, of.high)
                                  : fmt::format(" (from {:.3g})", of.low);
  };
  const char* grade = connector_grade(m);
  return fmt::format("  {:<14} mean {:.4g} dB{}, 97 % within {:.4g} dB{}, {}{}\n", how, m.mean_dB,
                     interval(m.mean_95), m.p97_dB, interval(m.p97_95),
                     grade ? fmt::format("grade {}", grade) : "no grade", allowed_grades_text(m));
}

}  // namespace

std::string to_text(const std::string& who, const CampaignSummary& s) {
  std::string text = fmt::format("{}: {} of {} inserted", who, s.successes, s.feasible);
  if (s.feasible > 0)
    text += fmt::format(", {:.1f} % (95 % {:.1f} to {:.1f})", 100 * s.success_rate,
                        100 * s.wilson.low, 100 * s.wilson.high);
  text += "\n";
  if (s.feasible > 0) text += fmt::format("  {:<14} {}\n", "to show", to_show_text(s));
  if (s.target) text += fmt::format("  {:<14} {}\n", "target", to_text(*s.target));
  for (int i = 1; i < kOutcomes; ++i)
    if (const auto n = s.outcomes[static_cast<std::size_t>(i)]; n > 0)
      text += fmt::format("  {:<14} {}\n", name(static_cast<Outcome>(i)), n);
  if (const std::string note = time_limit_note(s); !note.empty()) text += "  " + note + "\n";
  if (s.worst) text += to_text(*s.worst, s.success_rate);
  const auto line = [&](const char* what, const Spread& spread, double unit, const char* in) {
    if (std::isfinite(spread.median))
      text += fmt::format("  {:<14} median {:.4g} {}, p95 {:.4g} {}\n", what, unit * spread.median,
                          in, unit * spread.p95, in);
  };
  line("time", s.time, 1, "s");
  line("peak force", s.peak_force, 1e6, "uN");
  if (std::isfinite(s.loss_dB.median))
    text += fmt::format("  {:<14} median {:.4g} dB, p95 {:.4g} dB, with an ideal partner\n",
                        "joint loss", s.loss_dB.median, s.loss_dB.p95);
  if (s.mated && s.mated->untuned.pairs > 0)
    text += to_text("mated", s.mated->untuned) + to_text("mated, tuned", s.mated->tuned) +
            fmt::format("  {:<14} {}\n", "graded for", to_text(s.mated->joint));
  if (s.unfinished > 0)
    text += fmt::format("  {:<14} {} of {} without a minimum: they lag behind until later ones\n",
                        "steps", s.unfinished, s.steps);
  if (!s.interventions) return text;
  text += fmt::format("  {:<14} in {} of {} trials\n", "interventions", s.interventions->trials,
                      s.trials);
  for (std::size_t i = 0; i < kInterventions; ++i)
    if (const auto [count, trials] = s.interventions->kinds[i]; count > 0) {
      text += fmt::format("    {:<12} {} in {} trials", kInterventionNames[i], count, trials);
      const std::size_t ended = s.interventions->gave_up[i];
      text += ended ? fmt::format(", ended {}\n", ended) : "\n";
    }
  return text;
}

std::string to_text(const Comparison& c) {
  return fmt::format(
      "same trials: {:+.1f} percentage points (95 % {:+.1f} to {:+.1f}), McNemar p = {:.2g}\n",
      100 * c.difference, 100 * c.interval.low, 100 * c.interval.high, c.mcnemar_p);
}

void add_trials(const std::string& controller, const std::vector<TrialResult>& results,
                const std::vector<DrawnQuantity>& drawn, Json& rows) {
  for (std::size_t k = 0; k < results.size(); ++k) {
    Json& row = rows.emplace_back(told_trial(results[k]));
    row["controller"] = controller;
    row["trial"] = k;
    for (const DrawnQuantity& quantity : drawn)
      row[quantity.name] = number_or_null(quantity.values[k]);
  }
}

Json supervisor_json(const SupervisorLimits& limits, const Scaling& scaling) {
  const std::string cannot = cannot_hold(limits);
  return {{"force_limit_uN", 1e6 * limits.force / scaling.force},
          {"brakes_for_uN", 1e6 * limits.brakes_for() / scaling.force},
          {"holds", cannot.empty()},
          {"why", cannot.empty() ? Json() : Json(cannot)}};
}

std::string supervisor_note(const SupervisorLimits& limits) {
  const std::string cannot = cannot_hold(limits);
  return cannot.empty() ? "" : "note: supervisor: " + cannot + "\n";
}

}  // namespace ferrule
