// ferrule bench: speed against error.
#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <tuple>

#include "app/plot.hpp"
#include "app/verb.hpp"
#include "bench/campaigns.hpp"
#include "bench/capture.hpp"
#include "bench/controllers.hpp"
#include "bench/events.hpp"
#include "bench/hard.hpp"
#include "bench/laws.hpp"
#include "bench/parameters.hpp"
#include "bench/parts.hpp"
#include "bench/peers.hpp"
#include "bench/plans.hpp"
#include "bench/recording.hpp"
#include "bench/sensors.hpp"
#include "bench/stepping.hpp"
#include "bench/tail.hpp"
#include "bench/turns.hpp"

namespace ferrule {
namespace {

struct BenchArguments {
  std::string what, plot;
  std::uint64_t seed = 1;
  std::optional<std::size_t> scenes;
  std::size_t trials = 100;
  std::string scene;
  Output output;
};

constexpr std::size_t kScenes = 200;

std::vector<std::string> scenes_of(const BenchArguments& a) {
  return a.scene.empty() ? shipped_scenes() : std::vector<std::string>{a.scene};
}

// Every benchmark makes its own scenes of one that ships. Partial where Ctrl-C ended it.
Provenance provenance_of_bench() {
  Provenance provenance;
  provenance.read(scene_file("paper"));
  if (interrupted()) provenance.partial("the cases as far as they were run");
  return provenance;
}

// Of the benchmarks that draw motions in shipped scenes.
Provenance provenance_of_steps(const BenchArguments& a, const std::vector<std::string>& scenes) {
  Provenance provenance = provenance_of_bench();
  for (const std::string& name : scenes)
    if (name != "paper") provenance.read(scene_file(name));
  provenance.seed("scenes, starts and motions", a.seed);
  return provenance;
}

// Progress of a benchmark, which Ctrl-C ends between two cases.
GoOn watched(const std::string& what) {
  return [progress = std::make_shared<Progress>(what, 1),
          ends = std::make_shared<EndsBetweenCases>()](std::size_t done, std::size_t all) {
    (*progress)(done, "", all);
    return !interrupted();
  };
}

int ended(bool passed) {
  return interrupted() ? kInterrupted : passed ? kDone : kFailed;
}

// Error and cost of everything with a name, one line for each name.
template <class Row, class Name, class Error, class Cost>
Plot work_precision(const std::string& title, const std::string& cost_label,
                    const std::string& error_label, const std::vector<Row>& rows, Name name,
                    Error error, Cost cost) {
  std::map<std::string, Series> series;
  for (const Row& row : rows) {
    Series& s = series[name(row)];
    s.name = name(row);
    s.style = Series::points_on_line;
    s.x.push_back(error(row));
    s.y.push_back(cost(row));
  }
  Axes axes{error_label, cost_label, true, true, {}};
  for (auto& [_, s] : series) axes.series.push_back(s);
  return {title, {axes}};
}

// The orders of a quadrature are one series; other fidelities are points of their own.
std::string series_of(const LawRow& r) {
  const std::size_t order = r.fidelity.find(" of order");
  return r.name + ", " + r.fidelity.substr(0, order);
}

void draw(const std::string& folder, const std::vector<LawRow>& laws,
          const std::vector<SteppingRow>& stepping) {
  make_plot_folder(folder);
  write_svg(folder + "/laws.svg",
            work_precision(
                "Force laws: cost against error", "ns per evaluation", "largest relative error",
                laws, series_of, [](const LawRow& r) { return r.relative_error; },
                [](const LawRow& r) { return r.ns; }));
  write_svg(folder + "/stepping.svg",
            work_precision(
                "Stepping: cost against error", "us per simulated second", "tip error [nm]",
                stepping, [](const SteppingRow& r) { return r.method + ", " + r.scene_case; },
                // What is exact to rounding would only stretch the axis.
                [](const SteppingRow& r) { return r.tip_error_nm > 1e-6 ? r.tip_error_nm : NAN; },
                [](const SteppingRow& r) { return r.us_per_simulated_s; }));
  fmt::print(stderr, "wrote {0}/laws.svg and {0}/stepping.svg\n", printable(folder));
}

Json law_json(const LawRow& r) {
  return {{"name", r.name},
          {"fidelity", r.fidelity},
          {"ns", r.ns},
          {"relative_error", r.relative_error}};
}

Json stepping_json(const SteppingRow& r) {
  return {{"method", r.method},
          {"case", r.scene_case},
          {"step_s", r.step_s},
          {"ns_per_step", r.ns_per_step},
          {"us_per_simulated_s", r.us_per_simulated_s},
          {"tip_error_nm", number_or_null(r.tip_error_nm)},
          {"force_error_relative", number_or_null(r.force_error_relative)},
          {"newton_iterations", r.newton_iterations},
          {"not_converged", r.not_converged},
          {"halvings", r.rejected}};
}

Json controller_json(const ControllerRow& r) {
  return {{"name", r.name}, {"shape", r.shape}, {"ns", r.ns}, {"relative_error", r.relative_error}};
}

// Of force laws and of controllers: what it is, how it is computed, cost and error.
void print_heading(const char* what, const char* how) {
  fmt::print("{:<15} {:<42} {:>9} {:>15}\n", what, how, "ns", "relative error");
}
void print_line(const std::string& what, const std::string& how, double ns, double error) {
  fmt::print("{:<15} {:<42} {:9.1f} {:15.2g}\n", what, how, ns, error);
}

void print_stepping(const std::vector<SteppingRow>& rows) {
  fmt::print("{:<15} {:<26} {:>9} {:>11} {:>16} {:>13} {:>12} {:>9} {:>7} {:>7}\n", "method",
             "case", "step [s]", "ns per step", "us per simul. s", "tip err. [nm]", "force error",
             "Newton/st", "failed", "halved");
  for (const SteppingRow& r : rows)
    fmt::print("{:<15} {:<26} {:9.0e} {:11.0f} {:16.4g} {:>13} {:>12} {:>9.2f} {:>7} {:>7}\n",
               r.method, r.scene_case, r.step_s, r.ns_per_step, r.us_per_simulated_s,
               number_or("diverged", "{:.3g}", r.tip_error_nm),
               number_or("-", "{:.2g}", r.force_error_relative), r.newton_iterations,
               r.not_converged, r.rejected);
}

Json campaign_json(const CampaignRow& r) {
  return {{"scene", r.scene},
          {"controller", r.controller},
          {"step_s", r.step_s},
          {"steps", r.steps},
          {"ns_per_step", r.ns_per_step},
          {"iterations_in_contact", r.iterations_in_contact},
          {"evaluations", r.evaluations},
          {"evaluations_max", r.evaluations_max},
          {"not_converged", r.not_converged},
          {"capped", r.capped}};
}

void print_campaigns(const std::vector<CampaignRow>& rows) {
  fmt::print("{:<10} {:<14} {:>8} {:>8} {:>11} {:>14} {:>9} {:>9} {:>7} {:>7}\n", "campaign in",
             "controller", "step [s]", "steps", "ns per step", "iter. contact", "evals/st", "most",
             "failed", "capped");
  for (const CampaignRow& r : rows)
    fmt::print("{:<11} {:<14} {:8.0e} {:>8} {:11.0f} {:14.2f} {:9.2f} {:>9} {:>7} {:>7}\n", r.scene,
               r.controller, r.step_s, r.steps, r.ns_per_step, r.iterations_in_contact,
               r.evaluations, r.evaluations_max, r.not_converged, r.capped);
}

void print(const std::vector<LawRow>& laws, const std::vector<SteppingRow>& stepping,
           const std::vector<CampaignRow>& campaigns,
           const std::vector<ControllerRow>& controllers) {
  print_heading("law", "fidelity");
  for (const LawRow& r : laws) print_line(r.name, r.fidelity, r.ns, r.relative_error);
  fmt::print("\n");
  print_stepping(stepping);
  fmt::print("\n");
  print_campaigns(campaigns);
  fmt::print("\n");
  print_heading("controller", "shape");
  for (const ControllerRow& r : controllers) print_line(r.name, r.shape, r.ns, r.relative_error);
}

int speed_and_error(const BenchArguments& a) {
  const std::vector<LawRow> laws = bench_laws(watched("laws"));
  const std::vector<SteppingRow> stepping = bench_stepping(watched("stepping"));
  const std::vector<CampaignRow> campaigns = bench_campaigns(watched("campaigns"));
  const std::vector<ControllerRow> controllers = bench_controllers(watched("controllers"));
  if (!a.plot.empty() && !interrupted()) draw(a.plot, laws, stepping);
  const Provenance provenance = provenance_of_bench();
  Json json = {{"laws", json_list(laws, law_json)},
               {"stepping", json_list(stepping, stepping_json)},
               {"campaigns", json_list(campaigns, campaign_json)},
               {"controllers", json_list(controllers, controller_json)}};
  if (a.output.text()) {
    print(laws, stepping, campaigns, controllers);
    fmt::print("{}", provenance.foot());
  } else if (a.output.csv) {  // the tables in one
    json["table"] = Json::array();
    for (const char* of : {"laws", "stepping", "campaigns", "controllers"})
      for (const Json& row : json[of]) {
        json["table"].push_back({{"of", of}});
        json["table"].back().update(row);
      }
  }
  print_result(a.output, json, "table", provenance);
  return ended(true);
}

const char* status(const HardRow& r) {
  return !r.finite ? "NaN" : r.gained ? "gained" : r.passed() ? "ok" : "wrong";
}

Json hard_json(const HardRow& r) {
  return {{"case", r.name},
          {"step_s", number_or_null(r.step_s)},
          {"result", r.result},
          {"error", number_or_null(r.error)},
          {"status", status(r)}};
}

int hard(const BenchArguments& a) {
  const std::vector<HardRow> rows = bench_hard(watched("hard cases"));
  const Provenance provenance = provenance_of_bench();
  if (a.output.text()) {
    fmt::print("{:<62} {:>8} {:>9} {:<7} {}\n", "case", "step [s]", "error", "status", "result");
    for (const HardRow& r : rows)
      fmt::print("{:<62} {:>8} {:9.2g} {:<7} {}\n", r.name, number_or("-", "{:g}", r.step_s),
                 r.error, status(r), r.result);
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output, {{"rows", json_list(rows, hard_json)}}, "rows", provenance);
  return ended(std::all_of(rows.begin(), rows.end(), std::mem_fn(&HardRow::passed)));
}

Json capture_json(const CaptureRow& r) {
  return {{"offset_clearances", r.offset_clearances},
          {"capture_clearances", r.capture_clearances},
          {"direction_deg", r.direction_deg},
          {"speed_um_s", r.speed_um_s},
          {"step_s", r.step_s},
          {"edge_um", r.edge_um},
          {"cleave_deg", r.cleave_deg},
          {"lead_in", r.lead_in},
          {"inserted", r.inserted}};
}

void print_capture(const std::vector<CaptureRow>& rows, std::size_t wrong) {
  // By lead-in, edge, cleave, offset and what must be: how many went in, of how many.
  std::map<std::tuple<bool, double, double, double, bool>, std::pair<std::size_t, std::size_t>>
      counts;
  for (const CaptureRow& r : rows) {
    auto& [in, all] =
        counts[{r.lead_in, r.edge_um, r.cleave_deg, r.offset_clearances, r.expected()}];
    in += r.inserted;
    ++all;
  }
  fmt::print("{:<12} {:>10} {:>12} {:>10} {:>12} {:>12}\n", "mouth", "edge [um]", "cleave [deg]",
             "offset", "must go in", "inserted");
  for (const auto& [key, count] : counts)
    fmt::print("{:<12} {:>10g} {:>12g} {:>10.5g} {:>12} {:>12}\n",
               std::get<0>(key) ? "lead-in" : "sharp", std::get<1>(key), std::get<2>(key),
               std::get<3>(key), std::get<4>(key) ? "yes" : "no",
               fmt::format("{} of {}", count.first, count.second));
  fmt::print(
      "offsets in clearances; a sharp bore takes those below 1, a lead-in those below its rim; a "
      "rounded end its radius more; a cleaved one while its foremost point is over the bore\n"
      "{} of {} wrong\n",
      wrong, rows.size());
}

int capture(const BenchArguments& a) {
  const std::vector<CaptureRow> rows = bench_capture(watched("capture"));
  const Provenance provenance = provenance_of_bench();
  std::size_t wrong = 0;
  for (const CaptureRow& r : rows) wrong += r.inserted != r.expected();
  if (a.output.text()) {
    print_capture(rows, wrong);
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output, {{"rows", json_list(rows, capture_json)}, {"wrong", wrong}}, "rows",
               provenance);
  return ended(wrong == 0);
}

// The rows of what was measured: as a table, which `print` prints, with the provenance below it, or
// as what was asked for.
template <class Row>
int tell(const BenchArguments& a, const std::vector<Row>& rows,
         void (*print)(const std::vector<Row>&), Json (*to_json)(const Row&),
         const Provenance& provenance) {
  if (a.output.text()) {
    print(rows);
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output, {{"rows", json_list(rows, to_json)}}, "rows", provenance);
  return ended(true);
}

Json recording_json(const RecordingRow& r) {
  return {{"scene", r.scene},
          {"rows", r.rows},
          {"us_per_row", r.us_per_row},
          {"us_per_row_written", r.us_per_row_written},
          {"kB_per_s", r.kB_per_s}};
}

void print_recording(const std::vector<RecordingRow>& rows) {
  fmt::print("{:<10} {:>8} {:>18} {:>18} {:>14}\n", "scene", "rows", "us a row, recorded",
             "us a row, written", "kB per second");
  for (const RecordingRow& r : rows)
    fmt::print("{:<10} {:>8} {:>18.2f} {:>18.2f} {:>14.0f}\n", r.scene, r.rows, r.us_per_row,
               r.us_per_row_written, r.kB_per_s);
  fmt::print("recorded: by the thread of the loop; written: by another one, afterwards\n");
}

int recording(const BenchArguments& a) {
  return tell(a, bench_recording(watched("recording")), print_recording, recording_json,
              provenance_of_bench());
}

Json tail_json(const TailRow& r) {
  return {{"scene", r.scene},
          {"steps", r.steps},
          {"not_converged", r.not_converged},
          {"capped", r.capped},
          {"evaluations_p9999", r.evaluations_p9999},
          {"evaluations_max", r.evaluations_max},
          {"p9999_us", r.p9999_us},
          {"worst_us", r.worst_us},
          {"loops", r.loops},
          {"loops_that_gained", r.loops_that_gained}};
}

void print_tail(const std::vector<TailRow>& rows) {
  fmt::print("{:<10} {:>9} {:>7} {:>7} {:>12} {:>9} {:>12} {:>9} {:>6} {:>7}\n", "scene", "steps",
             "failed", "capped", "eval 99.99 %", "eval most", "us 99.99 %", "us most", "loops",
             "gained");
  for (const TailRow& r : rows)
    fmt::print("{:<10} {:>9} {:>7} {:>7} {:>12} {:>9} {:>12.3g} {:>9.3g} {:>6} {:>7}\n", r.scene,
               r.steps, r.not_converged, r.capped, r.evaluations_p9999, r.evaluations_max,
               r.p9999_us, r.worst_us, r.loops, r.loops_that_gained);
}

int tail(const BenchArguments& a) {
  return tell(a, bench_tail(a.seed, a.scenes.value_or(kScenes), watched("tail")), print_tail,
              tail_json, provenance_of_steps(a, shipped_scenes()));
}

Json event_json(const EventRow& r) {
  return {{"scene", r.scene},
          {"motion", r.motion},
          {"step_s", r.step_s},
          {"pose_difference_clearances", r.pose_difference_clearances},
          {"force_difference_relative", r.force_difference_relative},
          {"share_above_1_percent", r.share_above_1_percent},
          {"us_per_simulated_s", r.us_per_simulated_s},
          {"not_converged", r.not_converged},
          {"capped", r.capped}};
}

void print_events(const std::vector<EventRow>& rows) {
  fmt::print("{:<10} {:<10} {:>9} {:>18} {:>12} {:>11} {:>16} {:>7} {:>7}\n", "scene", "motion",
             "step [ms]", "pose [clearances]", "force", "above 1 %", "us per simul. s", "failed",
             "capped");
  for (const EventRow& r : rows)
    fmt::print("{:<10} {:<10} {:9.4g} {:18.2g} {:12.2g} {:11.2g} {:16.4g} {:>7} {:>7}\n", r.scene,
               r.motion, 1e3 * r.step_s, r.pose_difference_clearances, r.force_difference_relative,
               r.share_above_1_percent, r.us_per_simulated_s, r.not_converged, r.capped);
}

int events(const BenchArguments& a) {
  const auto rows = bench_events(a.seed, a.scenes.value_or(2), scenes_of(a), watched("events"));
  return tell(a, rows, print_events, event_json, provenance_of_steps(a, scenes_of(a)));
}

Json parameter_json(const ParameterRow& r) {
  return {{"parameter", r.parameter},
          {"factor", r.factor},
          {"value", r.value},
          {"steps", r.steps},
          {"evaluations", r.evaluations},
          {"evaluations_max", r.evaluations_max},
          {"not_converged", r.not_converged},
          {"iteration_limit", r.iteration_limit},
          {"error_p99_clearances", r.error_p99},
          {"error_max_clearances", r.error_max}};
}

void print_parameters(const std::vector<ParameterRow>& rows) {
  fmt::print("{:<22} {:>6} {:>9} {:>11} {:>9} {:>7} {:>8} {:>12} {:>12}\n", "parameter", "factor",
             "value", "evaluations", "most", "failed", "at limit", "error 99 %", "error most");
  for (const ParameterRow& r : rows)
    fmt::print("{:<22} {:>6.2g} {:>9.4g} {:>11.4f} {:>9} {:>7} {:>8} {:>12.2g} {:>12.2g}\n",
               r.parameter, r.factor, r.value, r.evaluations, r.evaluations_max, r.not_converged,
               r.iteration_limit, r.error_p99, r.error_max);
  fmt::print(
      "evaluations: of the potential, per step; error: of a step against a strict one from the "
      "same state, in clearances\n");
}

int parameters(const BenchArguments& a) {
  const auto rows =
      bench_parameters(a.seed, a.scenes.value_or(1), scenes_of(a), watched("parameters"));
  return tell(a, rows, print_parameters, parameter_json, provenance_of_steps(a, scenes_of(a)));
}

Json turn_json(const TurnRow& r) {
  return {{"scene", r.scene},       {"motion", r.motion}, {"starts", r.starts},    {"off", r.off},
          {"turned_90", r.quarter}, {"turned_37", r.any}, {"mirrored", r.mirrored}};
}

void print_turns(const std::vector<TurnRow>& rows) {
  fmt::print("{:<10} {:<10} {:>13} {:>12} {:>12} {:>12} {:>12}\n", "scene", "motion",
             "turned by 90", "by 37 deg", "mirrored", "starts", "off by 1e-6");
  for (const TurnRow& r : rows)
    fmt::print("{:<10} {:<10} {:>13.2g} {:>12.2g} {:>12.2g} {:>12} {:>12}\n", r.scene, r.motion,
               r.quarter, r.any, r.mirrored, r.starts, r.off);
}

int turns(const BenchArguments& a) {
  return tell(a, bench_turns(a.seed, a.scenes.value_or(kScenes), watched("turns")), print_turns,
              turn_json, provenance_of_steps(a, shipped_scenes()));
}

Json part_json(const PartRow& r) {
  return {{"scene", r.scene},
          {"part", r.part},
          {"controller", r.controller},
          {"trials", r.trials},
          {"inserted", r.inserted},
          {"low", number_or_null(r.interval.low)},
          {"high", number_or_null(r.interval.high)}};
}

void print_parts(const std::vector<PartRow>& rows) {
  fmt::print("{:<10} {:<20} {:<18} {:>12} {:>18}\n", "scene", "with", "controller", "inserted",
             "95 % [%]");
  for (const PartRow& r : rows)
    fmt::print("{:<10} {:<20} {:<18} {:>12} {:>18}\n", r.scene, r.part, r.controller,
               fmt::format("{} of {}", r.inserted, r.trials),
               fmt::format("{:.1f} to {:.1f}", 100 * r.interval.low, 100 * r.interval.high));
}

int parts(const BenchArguments& a) {
  return tell(a, bench_parts(a.seed, a.trials, scenes_of(a), watched("campaigns")), print_parts,
              part_json, provenance_of_steps(a, scenes_of(a)));
}

Json plan_json(const PlanRow& r) {
  return {{"scene", r.scene},
          {"plan_for", r.plan_for},
          {"planning_s", r.planning_s},
          {"error_bound", number_or_null(r.error_bound)},
          {"sampled_twice", r.sampled_twice},
          {"full_us_per_simulated_s", r.full_us_per_simulated_s},
          {"shipped_us_per_simulated_s", r.shipped_us_per_simulated_s},
          {"planned_us_per_simulated_s", r.planned_us_per_simulated_s},
          {"ratio", r.ratio},
          {"trials", r.trials},
          {"full_inserted", r.full_inserted},
          {"full_low", number_or_null(r.full_interval.low)},
          {"full_high", number_or_null(r.full_interval.high)},
          {"planned_inserted", r.planned_inserted},
          {"planned_low", number_or_null(r.planned_interval.low)},
          {"planned_high", number_or_null(r.planned_interval.high)}};
}

void print_plans(const std::vector<PlanRow>& rows) {
  fmt::print("{:<10} {:<8} {:>8} {:>9} {:>14} {:>10} {:>10} {:>10} {:>6} {:>7} {:>24} {:>24}\n",
             "scene", "for", "plan [s]", "bound", "sampled twice", "full", "shipped", "planned",
             "ratio", "trials", "full inserted", "planned inserted");
  for (const PlanRow& r : rows) {
    const auto inserted = [](std::size_t count, const Interval& i) {
      return fmt::format("{} ({:.1f} to {:.1f} %)", count, 100 * i.low, 100 * i.high);
    };
    fmt::print(
        "{:<10} {:<8} {:>8.2f} {:>9.2g} {:>14.2g} {:>10.0f} {:>10.0f} {:>10.0f} {:>6.2f} {:>7} "
        "{:>24} "
        "{:>24}\n",
        r.scene, r.plan_for, r.planning_s, r.error_bound, r.sampled_twice,
        r.full_us_per_simulated_s, r.shipped_us_per_simulated_s, r.planned_us_per_simulated_s,
        r.ratio, r.trials, inserted(r.full_inserted, r.full_interval),
        inserted(r.planned_inserted, r.planned_interval));
  }
  fmt::print(
      "full (every step solved), shipped, planned: us of the processor per simulated s of a "
      "campaign\n");
}

int plans(const BenchArguments& a) {
  return tell(a, bench_plans(a.seed, a.trials, scenes_of(a), watched("campaigns")), print_plans,
              plan_json, provenance_of_steps(a, scenes_of(a)));
}

Json sensor_json(const SensorRow& r) {
  return {{"scene", r.scene}, {"sensor", r.sensor}, {"trials", r.trials}, {"inserted", r.inserted}};
}

void print_sensors(const std::vector<SensorRow>& rows) {
  for (const SensorRow& r : rows)
    fmt::print("{:<10} {:<32} {:>4} of {}\n", r.scene, r.sensor, r.inserted, r.trials);
  fmt::print(
      "inserted by the law of 20 demonstrations, of the pairs of parts that fit; errors as parts "
      "of the force limit; none: straight in at constant velocity\n");
}

int sensors(const BenchArguments& a) {
  return tell(a, bench_sensors(a.seed, a.trials, scenes_of(a), watched("sensors")), print_sensors,
              sensor_json, provenance_of_steps(a, scenes_of(a)));
}

Json peer_json(const PeerRow& r) {
  return {{"engine", r.engine},
          {"version", r.version},
          {"settings", r.settings},
          {"segments", r.segments},
          {"step_s", r.step_s},
          {"us_per_simulated_ms", r.us_per_simulated_ms},
          {"pose_error_um", number_or_null(r.pose_error_um)},
          {"force_error_relative", number_or_null(r.force_error_relative)},
          {"penetration_um", number_or_null(r.penetration_um)},
          {"outside", r.outside},
          {"let_in", r.let_in}};
}

void print_peers(const std::vector<PeerRow>& rows) {
  fmt::print("{:<8} {:<8} {:>8} {:>8} {:>9} {:>10} {:>11} {:>11} {:>8}  {}\n", "engine", "version",
             "segments", "step [s]", "us per ms", "pose [um]", "force error", "penetr.[um]",
             "let in", "settings");
  for (const PeerRow& r : rows)
    fmt::print("{:<8} {:<8} {:>8} {:>8g} {:>9.3g} {:>10} {:>11} {:>11} {:>8}  {}\n", r.engine,
               r.version, r.segments ? fmt::format("{}", r.segments) : "round", r.step_s,
               r.us_per_simulated_ms, number_or("diverged", "{:.3g}", r.pose_error_um),
               number_or("diverged", "{:.2g}", r.force_error_relative),
               number_or("diverged", "{:.3g}", r.penetration_um),
               fmt::format("{} of {}", r.let_in, r.outside), r.settings);
  fmt::print(
      "pose, force and penetration: largest error in the motion, clearance 0.5 um; let in: of "
      "fibres that start beside a sharp bore\n");
}

int peers(const BenchArguments& a) {
  const PeerBench bench = bench_peers(watched("engines"));
  const Provenance provenance = provenance_of_bench();
  for (const std::string& missing : bench.missing)
    fmt::print(stderr, "ferrule: not measured: {}\n", missing);
  if (a.output.text()) {
    print_peers(bench.rows);
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output,
               {{"rows", json_list(bench.rows, peer_json)}, {"not_measured", bench.missing}},
               "rows", provenance);
  return ended(true);
}

}  // namespace

void add_bench(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("bench", "Speed against error of laws, stepping and controllers; capture");
  auto a = std::make_shared<BenchArguments>();
  verb->add_option(
          "what", a->what,
          "Unless given: laws, stepping, campaigns and controllers; hard: the hard cases; capture: "
          "from how far off the axis an end goes in; tail: the worst steps; events: the same "
          "motions at ever finer steps; turns: the same turned about the axis, mirrored, and "
          "continued from saved rows; parameters: the solver's, each halved and doubled; peers: "
          "other engines in the same motion; recording: the cost of a row; parts: success with "
          "curl, cleave, edge and the like; plans: planned against "
          "full campaigns; sensors: success against noise and bias of the force sensor")
      ->check(one_of({"hard", "capture", "tail", "events", "turns", "parameters", "peers",
                      "recording", "parts", "plans", "sensors"}));
  add_seed(
      *verb, a->seed,
      "Seed of the scenes, starts, motions and trials of tail, events, turns, parameters, parts, "
      "plans and sensors");
  verb->add_option(
          "--scene", a->scene,
          "Scene of events, parameters, parts, plans and sensors; all shipped ones unless given")
      ->type_name("SCENE");
  verb->add_option("--trials", a->trials,
                   "Trials of each controller in each scene of parts, plans and sensors")
      ->check(whole_number(1, 1000000))
      ->capture_default_str();
  verb->add_option("--scenes", a->scenes,
                   "Random scenes, and starts in shipped scenes, of tail, events, turns and "
                   "parameters; 200, 2 for events and 1 for parameters, unless given")
      ->check(whole_number(1, 1000000));
  verb->add_option("--plot", a->plot, "Draw work-precision plots into a folder")->type_name("DIR");
  add_output(*verb, a->output);
  add_examples(*verb, {"bench --plot pictures", "bench hard --json", "bench peers"});
  verb->callback([a, &run] {
    run = [a] {
      if (!a->what.empty() && !a->plot.empty())
        throw BadInput("--plot: there is nothing to draw of bench " + a->what);
      return a->what == "hard"         ? hard(*a)
             : a->what == "capture"    ? capture(*a)
             : a->what == "tail"       ? tail(*a)
             : a->what == "events"     ? events(*a)
             : a->what == "turns"      ? turns(*a)
             : a->what == "parameters" ? parameters(*a)
             : a->what == "peers"      ? peers(*a)
             : a->what == "recording"  ? recording(*a)
             : a->what == "parts"      ? parts(*a)
             : a->what == "plans"      ? plans(*a)
             : a->what == "sensors"    ? sensors(*a)
                                       : speed_and_error(*a);
    };
  });
}

}  // namespace ferrule
