#include "app/demo_report.hpp"

#include <fmt/format.h>

#include <cmath>

#include "app/demonstration_plot.hpp"
#include "app/failures.hpp"
#include "app/force_history_table.hpp"
#include "app/force_table.hpp"
#include "app/given_controller.hpp"
#include "app/html.hpp"
#include "app/output.hpp"
#include "app/validators.hpp"
#include "controller/campaign_table.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

Plot gap_plot(const Scene& scene) {
  std::vector<ForceRow> rows;
  for (const double gap : parse_range("1:500:200:log", "gap")) {
    if (1e-9 * gap > scene.world.annulus.clearance()) break;
    rows.push_back(force_row(scene.world, gap, 100, std::nullopt, 0, 0));
  }
  Plot plot = force_plot(rows, Sweep::gap, scene.name);
  plot.title = "Non-contact forces against the gap, 100 um inserted";
  return plot;
}

Plot depth_plot(const Scene& scene) {
  std::vector<ForceRow> rows;
  for (const double depth : parse_range("0:12:121", "depth"))
    rows.push_back(force_row(scene.world, 0, 100, depth, 0, 0));
  Plot plot = force_plot(rows, Sweep::depth, scene.name);
  plot.title = "Forces at a closed contact against the penetration";
  return plot;
}

// Outcome of every trial against where it started.
Plot start_map(const DemoReport& r, const std::vector<TrialResult>& results, const char* title) {
  Axes axes{"start y [um]", "start z [um]", false, false, {}};
  for (int i = 0; i < kOutcomes; ++i) {
    Series series{name(static_cast<Outcome>(i)), {}, {}, Series::points};
    for (std::size_t k = 0; k < results.size(); ++k) {
      if (results[k].outcome != static_cast<Outcome>(i)) continue;
      const State start = draw_start(*r.scene, r.trial_seed(), k);
      series.x.push_back(1e6 * start.tip[1]);
      series.y.push_back(1e6 * start.tip[2]);
    }
    if (!series.x.empty()) axes.series.push_back(series);
  }
  return {title, {axes}, 700, 520, true};
}

std::string gains_table(const LawFile& c) {
  HtmlTable table(
      {{"gain", false}, {"symbol", false}, {"value"}, {"95 % interval"}, {"unit", false}});
  for (std::size_t i = 0; i < kGains; ++i) {
    const FittedGain& g = c.gains[i];
    const std::string interval = std::isfinite(g.low)
                                     ? fmt::format("{:.4g} to {:.4g}", g.low, g.high)
                                     : std::string("open: at its bound");
    table.row({kGainTable[i].name, kGainTable[i].symbol, fmt::format("{:.4g}", g.value), interval,
               kGainTable[i].unit});
  }
  return table.html();
}

std::string success_table(const CampaignSummary& learned, const CampaignSummary& baseline) {
  HtmlTable table({{"", false},
                   {"inserted"},
                   {"success"},
                   {"95 % (Wilson)"},
                   {"trials still to show 99 % / 99.9 %"},
                   {"time [s], median / p95"},
                   {"peak force [uN], median / p95"},
                   {"loss with an ideal partner [dB], median / p95"}});
  for (const auto& [who, s] : {std::pair<const char*, const CampaignSummary&>{"learned", learned},
                               {"constant velocity", baseline}}) {
    const auto pair = [](const Spread& x, double unit, const char* format) {
      return number_or("&ndash;", format, unit * x.median) + " / " +
             number_or("&ndash;", format, unit * x.p95);
    };
    table.row(
        {who, fmt::format("{} of {}", s.successes, s.trials),
         fmt::format("{:.1f} %", 100 * s.success_rate),
         fmt::format("{:.1f} to {:.1f} %", 100 * s.wilson.low, 100 * s.wilson.high),
         trials_to_show_or("&ndash;", 0.99, s) + " / " + trials_to_show_or("&ndash;", 0.999, s),
         pair(s.time, 1, "{:.1f}"), pair(s.peak_force, 1e6, "{:.2f}"),
         pair(s.loss_dB, 1, "{:.3f}")});
  }
  return table.html();
}

std::string outcome_table(const CampaignSummary& learned, const CampaignSummary& baseline) {
  HtmlTable table({{"how a trial ended", false}, {"learned"}, {"constant velocity"}});
  for (std::size_t i = 0; i < kOutcomes; ++i)
    if (learned.outcomes[i] + baseline.outcomes[i] > 0)
      table.row({name(static_cast<Outcome>(i)), std::to_string(learned.outcomes[i]),
                 std::to_string(baseline.outcomes[i])});
  return table.html();
}

std::string recorded_table(const DemoReport& r) {
  HtmlTable table(
      {{"skill"}, {"episodes"}, {"inserted"}, {"median time [s]"}, {"median peak force [uN]"}});
  for (std::size_t i = 0; i < r.recorded.size();) {
    const double skill = r.recorded[i].skill;
    std::size_t episodes = 0, inserted = 0;
    std::vector<double> time, force;
    for (; i < r.recorded.size() && r.recorded[i].skill == skill; ++i, ++episodes) {
      const Recorded& one = r.recorded[i].recorded;
      inserted += one.end.outcome == Outcome::inserted;
      time.push_back(one.end.summary.task_time());
      force.push_back(1e6 * one.end.summary.peak_force);
    }
    table.row({fmt::format("{}", skill), std::to_string(episodes), std::to_string(inserted),
               fmt::format("{:.1f}", quantile(time, 0.5)),
               fmt::format("{:.2f}", quantile(force, 0.5))});
  }
  return table.html();
}

std::string summary_section(const DemoReport& r, const CampaignSummary& learned,
                            const CampaignSummary& baseline) {
  const Scene& scene = *r.scene;
  return fmt::format(
             "<h1>Inserting a {:g} um fibre into a {:g} um bore</h1>\n"
             "<p class=big>A controller learned from {} demonstrations (a fifth held out) inserted "
             "the fibre in {} of {} trials "
             "({:.1f} %; 95 % interval {:.1f} to {:.1f} %). Pushing straight in at constant speed "
             "did so in {} of the same {} trials ({:.1f} %).</p>\n",
             2e6 * scene.world.annulus.fibre_radius, 2e6 * scene.world.annulus.bore_radius,
             r.recorded.size(), learned.successes, learned.trials, 100 * learned.success_rate,
             100 * learned.wilson.low, 100 * learned.wilson.high, baseline.successes,
             baseline.trials, 100 * baseline.success_rate) +
         fmt::format(
             "<p>Everything here is simulated, the operators too. Scene <code>{}</code>, seed {}. "
             "The fibre starts {:g} um outside the bore, misaligned sideways with a standard "
             "deviation of {:g} um in each direction and tilted with {:g} mrad; a trial fails when "
             "the force at the holder exceeds {:g} uN. Recording took {:.1f} s, fitting {:.1f} s, "
             "the trials {:.1f} s.</p>\n",
             escaped(scene.name), r.seed, 1e6 * scene.start.distance, 1e6 * scene.start.lateral_sd,
             1e3 * scene.start.tilt_sd, 1e6 * scene.limits.force, r.record_seconds, r.fit_seconds,
             r.evaluate_seconds);
}

std::vector<TestedController> tested_controllers(const DemoReport& r) {
  const Scene& scene = *r.scene;
  const std::string command = fmt::format("./ferrule view --trial TRIAL {{}} {} --seed {}",
                                          r.scene_arguments, r.trial_seed());
  return {{"constant velocity", fmt::format(fmt::runtime(command), "--against constant-velocity"),
           baseline(kStraight, scene, r.trial_seed()), &r.baseline},
          {"learned controller", fmt::format(fmt::runtime(command), "controller.json"),
           controller_maker(r.fit.controller.law()), &r.learned}};
}

// What the demonstration that is shown and the trials looked like.
std::string replays_section(const DemoReport& r) {
  const Scene& scene = *r.scene;
  std::vector<ReplayRun> runs;
  std::vector<TrialMap> maps;
  if (!r.shown.empty()) {
    runs.push_back(replay_of(read_episode(r.shown), scene, "demonstration " + r.shown));
    thin(runs.back(), 100);
  }
  for (const TestedController& tested : tested_controllers(r))
    add_failures(scene, r.trial_seed(), tested, runs, maps);
  return "<h2>Watch it</h2>\n" +
         replay_section("a demonstration, and trials that failed", runs, maps);
}

// Every input that is not as in the shipped scene that is nearest.
std::string inputs_section(const DemoReport& r) {
  const SceneChanges of = changes_from_shipped(r.scene->document());
  std::string html = "<h2>The inputs</h2>\n<p>";
  if (of.changes.empty())
    return html + fmt::format("All inputs are those of the shipped scene <code>{}</code>.</p>\n",
                              escaped(of.from));
  html +=
      fmt::format("All inputs are those of the shipped scene <code>{}</code>, but for these:</p>\n",
                  escaped(of.from));
  HtmlTable table({{"key", false}, {"here", false}, {"in " + escaped(of.from), false}});
  const auto text = [](const Json& value) {
    return value.is_null() ? std::string("none") : escaped(value.dump());
  };
  for (const SceneChange& c : of.changes)
    table.row({"<code>" + escaped(c.key) + "</code>", text(c.value), text(c.shipped)});
  return html + table.html();
}

std::string forces_section(const Scene& scene) {
  return "<h2>The forces</h2>\n" +
         figure(gap_plot(scene),
                "Magnitudes; laws in the form the scene asks for. Compare Fig. 5 of the paper.") +
         figure(depth_plot(scene), "Attraction negative. Compare Fig. 7 of the paper.");
}

std::string demonstrations_section(const DemoReport& r) {
  std::string html = "<h2>The demonstrations</h2>\n" + recorded_table(r);
  if (r.shown.empty()) return html;
  return html +
         figure(demonstration_plot(read_episode(r.shown), *r.scene),
                "In the manner of Fig. 10 of the paper: the speed along &minus;x rises and falls "
                "back to 0; dots are the contact force. File <code>" +
                    escaped(r.shown) + "</code>.");
}

std::string law_section(const LawFit& fit) {
  const LawFile& c = fit.controller;
  return "<h2>The fitted law</h2>\n<pre>" +
         escaped(
             "v_x = -v_c r (1 - exp((d - d_e)/L)) / (1 + k |f|^2) + A_x f_x,  r = (s (2 - s))^2, s "
             "= min(1, t/t_r)\n"
             "v_y = A_y f_y + b_y + c_y d\nv_z = A_z f_z + b_z + c_z d") +
         "</pre>\n<p>In the hand's world: f is the felt force relative to that at rest, d the "
         "depth of the hand past the entrance, t the time since the start.</p>\n" +
         gains_table(c) +
         fmt::format(
             "<p>{} training episodes, {} held out. Velocity residual {:.3g} mm/s, held out {:.3g} "
             "mm/s; the law explains {:.0f} % of the velocities' variance. The operators' reaction "
             "time was identified as {:.2f} s and is not imitated.</p>\n",
             c.trained_on.episodes.size(), c.trained_on.held_out.size(), 1e3 * c.residual,
             1e3 * c.held_out_residual, 100 * fit.explained, c.reaction_time);
}

std::string trials_section(const DemoReport& r, const CampaignSummary& learned,
                           const CampaignSummary& baseline) {
  const Comparison c = compare(r.learned, r.baseline);
  return "<h2>By itself</h2>\n" + success_table(learned, baseline) +
         fmt::format(
             "<p>On the same trials the learned controller succeeds {:+.1f} percentage points more "
             "often (95 % {:+.1f} to {:+.1f}; McNemar p = {:.2g}).</p>\n",
             100 * c.difference, 100 * c.interval.low, 100 * c.interval.high, c.mcnemar_p) +
         "<h2>Where the failures come from</h2>\n" + outcome_table(learned, baseline) +
         figure(start_map(r, r.learned, "Learned controller: outcome against start"), "") +
         figure(start_map(r, r.baseline, "Constant velocity: outcome against start"),
                "Without yielding, the lateral force grows with the misalignment until it exceeds "
                "the limit; beyond the rim of the lead-in the fibre lands on the front face.");
}

// In the demonstration that is drawn, and in trials.
std::string acting_section(const DemoReport& r) {
  std::vector<NamedHistory> forces;
  if (!r.shown.empty())
    forces.push_back({"demonstration " + r.shown, force_history(read_episode(r.shown), *r.scene)});
  for (const TestedController& tested : tested_controllers(r))
    forces.push_back(forces_of_trials(*r.scene, r.trial_seed(), tested));
  return to_html(forces);
}

std::string commands_section(const DemoReport& r) {
  return "<h2>Again, step by step</h2>\n<pre>" +
         escaped(fmt::format(
             "./ferrule record {0} --skill 0.5 --episodes 10 --seed {1} --out episodes\n"
             "./ferrule record {0} --skill 0.9 --episodes 10 --seed {1} --out episodes --append\n"
             "./ferrule fit episodes --method ceres --seed {1} --out controller.json\n"
             "./ferrule evaluate controller.json {0} --trials {2} --seed {3} "
             "--baseline constant-velocity",
             r.scene_arguments, r.seed, r.learned.size(), r.trial_seed())) +
         "</pre>\n<p>" + escaped(r.provenance.head() + r.provenance.foot()) + "</p>\n";
}

}  // namespace

void write_report(const std::string& file, const DemoReport& r) {
  const CampaignSummary learned = summarise(r.learned), baseline = summarise(r.baseline);
  write_text(file, replay_head("ferrule: demo report") + summary_section(r, learned, baseline) +
                       replays_section(r) + inputs_section(r) + forces_section(*r.scene) +
                       demonstrations_section(r) + law_section(r.fit) +
                       trials_section(r, learned, baseline) + acting_section(r) +
                       commands_section(r) + "</body></html>\n");
}

Json report_json(const DemoReport& r) {
  Json json = to_json(summarise(r.learned));
  json["scene"] = r.scene->name;
  json["seed"] = r.seed;
  json["baseline"] = to_json(summarise(r.baseline));
  add_json(compare(r.learned, r.baseline), json["baseline"]);
  return json;
}

std::string report_text(const DemoReport& r) {
  return to_text("learned controller", summarise(r.learned)) +
         to_text("constant velocity", summarise(r.baseline)) +
         to_text(compare(r.learned, r.baseline));
}

}  // namespace ferrule
