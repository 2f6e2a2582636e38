// ferrule bench: speed against error.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <tuple>

#include "app/columns.hpp"
#include "app/interrupt.hpp"
#include "app/loaded_verb.hpp"
#include "app/output.hpp"
#include "app/plot.hpp"
#include "app/progress.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
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
  std::size_t scenes = 0, trials = 100;  // scenes 0: as many as the benchmark takes by itself
  std::string scene;
  Output output;
};

std::vector<std::string> scenes_of(const BenchArguments& a) {
  return a.scene.empty() ? shipped_scenes() : std::vector<std::string>{a.scene};
}

// What a benchmark found.
struct Told {
  std::string text;  // tables, and notes that explain them
  Json json;         // the table is its "rows"
  bool passed = true;
};

// What was measured as a table, which `note` explains.
template <class Row>
Told told(const Columns<Row>& columns, const std::vector<Row>& rows, const std::string& note = "") {
  return {table_text(columns, rows) + note, {{"rows", table_json(columns, rows)}}};
}

// Progress of a benchmark, which Ctrl-C ends between two cases.
GoOn watched(const std::string& what) {
  return [progress = std::make_shared<Progress>(what, 1),
          ends = std::make_shared<EndsAfter>("case")](std::size_t done, std::size_t all) {
    (*progress)(done, "", all);
    return !interrupted();
  };
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

// Of force laws and of controllers: what it is, `how` it is computed, cost and error.
template <class Row>
Columns<Row> cost_columns(const char* what, const char* how, std::string Row::*computed) {
  return {{"name", what, "<15", &Row::name},
          {how, how, "<42", computed},
          {"ns", "ns", ">9.1f", &Row::ns},
          {"relative_error", "relative error", ">15.2g", &Row::relative_error}};
}

Columns<SteppingRow> stepping_columns() {
  return {{"method", "method", "<15", &SteppingRow::method},
          {"case", "case", "<26", &SteppingRow::scene_case},
          {"step_s", "step [s]", ">9.0e", &SteppingRow::step_s},
          {"ns_per_step", "ns per step", ">11.0f", &SteppingRow::ns_per_step},
          {"us_per_simulated_s", "us per simul. s", ">16.4g", &SteppingRow::us_per_simulated_s},
          {"tip_error_nm", "tip err. [nm]", ">13.3g", &SteppingRow::tip_error_nm, "diverged"},
          {"force_error_relative", "force error", ">12.2g", &SteppingRow::force_error_relative},
          {"newton_iterations", "Newton/st", ">9.2f", &SteppingRow::newton_iterations},
          {"not_converged", "failed", ">7", &SteppingRow::not_converged},
          {"halvings", "halved", ">7", &SteppingRow::rejected}};
}

Columns<CampaignRow> campaign_columns() {
  return {{"scene", "campaign in", "<11", &CampaignRow::scene},
          {"controller", "controller", "<14", &CampaignRow::controller},
          {"step_s", "step [s]", ">8.0e", &CampaignRow::step_s},
          {"steps", "steps", ">8", &CampaignRow::steps},
          {"ns_per_step", "ns per step", ">11.0f", &CampaignRow::ns_per_step},
          {"iterations_in_contact", "iter. contact", ">14.2f", &CampaignRow::iterations_in_contact},
          {"evaluations", "evals/st", ">9.2f", &CampaignRow::evaluations},
          {"evaluations_max", "most", ">9", &CampaignRow::evaluations_max},
          {"not_converged", "failed", ">7", &CampaignRow::not_converged},
          {"capped", "capped", ">7", &CampaignRow::capped}};
}

Told speed_and_error(const BenchArguments& a) {
  const std::vector<LawRow> laws = bench_laws(watched("laws"));
  const std::vector<SteppingRow> stepping = bench_stepping(watched("stepping"));
  const std::vector<CampaignRow> campaigns = bench_campaigns(watched("campaigns"));
  const std::vector<ControllerRow> controllers = bench_controllers(watched("controllers"));
  if (!a.plot.empty() && !interrupted()) draw(a.plot, laws, stepping);
  const auto of_laws = cost_columns("law", "fidelity", &LawRow::fidelity);
  const auto of_controllers = cost_columns("controller", "shape", &ControllerRow::shape);
  Json json = {{"laws", table_json(of_laws, laws)},
               {"stepping", table_json(stepping_columns(), stepping)},
               {"campaigns", table_json(campaign_columns(), campaigns)},
               {"controllers", table_json(of_controllers, controllers)}};
  if (a.output.csv) {  // the tables in one
    Json rows = Json::array();
    for (const char* of : {"laws", "stepping", "campaigns", "controllers"})
      for (const Json& row : json[of]) {
        rows.push_back({{"of", of}});
        rows.back().update(row);
      }
    json["rows"] = rows;
  }
  return {table_text(of_laws, laws) + "\n" + table_text(stepping_columns(), stepping) + "\n" +
              table_text(campaign_columns(), campaigns) + "\n" +
              table_text(of_controllers, controllers),
          json};
}

const char* status(const HardRow& r) {
  return !r.finite ? "NaN" : r.gained ? "gained" : r.passed() ? "ok" : "wrong";
}

Told hard(const BenchArguments&) {
  const std::vector<HardRow> rows = bench_hard(watched("hard cases"));
  Told all = told({{"case", "case", "<62", &HardRow::name},
                   {"step_s", "step [s]", ">8g", &HardRow::step_s},
                   {"error", "error", ">9.2g", &HardRow::error, "nan"},
                   {"status", "status", "<7", status},
                   {"result", "result", "", &HardRow::result}},
                  rows);
  all.passed = std::all_of(rows.begin(), rows.end(), std::mem_fn(&HardRow::passed));
  return all;
}

Columns<CaptureRow> capture_columns() {
  return {{"offset_clearances", "", "", &CaptureRow::offset_clearances},
          {"capture_clearances", "", "", &CaptureRow::capture_clearances},
          {"direction_deg", "", "", &CaptureRow::direction_deg},
          {"speed_um_s", "", "", &CaptureRow::speed_um_s},
          {"step_s", "", "", &CaptureRow::step_s},
          {"edge_um", "", "", &CaptureRow::edge_um},
          {"cleave_deg", "", "", &CaptureRow::cleave_deg},
          {"lead_in", "", "", &CaptureRow::lead_in},
          {"inserted", "", "", &CaptureRow::inserted}};
}

// How many went in of those alike: by lead-in, edge, cleave, offset and what must be.
using CaptureCount = std::pair<const std::tuple<bool, double, double, double, bool>,
                               std::pair<std::size_t, std::size_t>>;
Columns<CaptureCount> capture_count_columns() {
  return {{"", "mouth", "<12", [](auto& c) { return std::get<0>(c.first) ? "lead-in" : "sharp"; }},
          {"", "edge [um]", ">10g", [](auto& c) { return std::get<1>(c.first); }},
          {"", "cleave [deg]", ">12g", [](auto& c) { return std::get<2>(c.first); }},
          {"", "offset", ">10.5g", [](auto& c) { return std::get<3>(c.first); }},
          {"", "must go in", ">12", [](auto& c) { return std::get<4>(c.first) ? "yes" : "no"; }},
          {"", "inserted", ">12",
           [](auto& c) { return fmt::format("{} of {}", c.second.first, c.second.second); }}};
}

Told capture(const BenchArguments&) {
  const std::vector<CaptureRow> rows = bench_capture(watched("capture"));
  std::size_t wrong = 0;
  std::map<CaptureCount::first_type, CaptureCount::second_type> counts;
  for (const CaptureRow& r : rows) {
    wrong += r.inserted != r.expected();
    auto& [in, all] =
        counts[{r.lead_in, r.edge_um, r.cleave_deg, r.offset_clearances, r.expected()}];
    in += r.inserted;
    ++all;
  }
  const std::string text = fmt::format(
      "{}offsets in clearances; a sharp bore takes those below 1, a lead-in those below its rim; a "
      "rounded end its radius more; a cleaved one while its foremost point is over the bore\n"
      "{} of {} wrong\n",
      table_text(capture_count_columns(), {counts.begin(), counts.end()}), wrong, rows.size());
  return {text, {{"rows", table_json(capture_columns(), rows)}, {"wrong", wrong}}, wrong == 0};
}

Told recording(const BenchArguments&) {
  return told(
      {{"scene", "scene", "<10", &RecordingRow::scene},
       {"rows", "rows", ">8", &RecordingRow::rows},
       {"us_per_row", "us a row, recorded", ">18.2f", &RecordingRow::us_per_row},
       {"us_per_row_written", "us a row, written", ">18.2f", &RecordingRow::us_per_row_written},
       {"kB_per_s", "kB per second", ">14.0f", &RecordingRow::kB_per_s}},
      bench_recording(watched("recording")),
      "recorded: time of the loop's thread; written: until a child process has made the file\n");
}

Told tail(const BenchArguments& a) {
  return told({{"scene", "scene", "<10", &TailRow::scene},
               {"steps", "steps", ">9", &TailRow::steps},
               {"not_converged", "failed", ">7", &TailRow::not_converged},
               {"capped", "capped", ">7", &TailRow::capped},
               {"evaluations_p9999", "eval 99.99 %", ">12", &TailRow::evaluations_p9999},
               {"evaluations_max", "eval most", ">9", &TailRow::evaluations_max},
               {"p9999_us", "us 99.99 %", ">12.3g", &TailRow::p9999_us},
               {"worst_us", "us most", ">9.3g", &TailRow::worst_us},
               {"loops", "loops", ">6", &TailRow::loops},
               {"loops_that_gained", "gained", ">7", &TailRow::loops_that_gained}},
              bench_tail(a.seed, a.scenes, watched("tail")));
}

Told events(const BenchArguments& a) {
  return told(
      {{"scene", "scene", "<10", &EventRow::scene},
       {"motion", "motion", "<10", &EventRow::motion},
       {"step_s", "", "", &EventRow::step_s},
       {"", "step [ms]", ">9.4g", [](auto& r) { return 1e3 * r.step_s; }},
       {"pose_difference_clearances", "pose [clearances]", ">18.2g",
        &EventRow::pose_difference_clearances},
       {"force_difference_relative", "force", ">12.2g", &EventRow::force_difference_relative},
       {"share_above_1_percent", "above 1 %", ">11.2g", &EventRow::share_above_1_percent},
       {"us_per_simulated_s", "us per simul. s", ">16.4g", &EventRow::us_per_simulated_s},
       {"not_converged", "failed", ">7", &EventRow::not_converged},
       {"capped", "capped", ">7", &EventRow::capped}},
      bench_events(a.seed, a.scenes, scenes_of(a), watched("events")));
}

Told parameters(const BenchArguments& a) {
  return told({{"parameter", "parameter", "<22", &ParameterRow::parameter},
               {"factor", "factor", ">6.2g", &ParameterRow::factor},
               {"value", "value", ">9.4g", &ParameterRow::value},
               {"steps", "", "", &ParameterRow::steps},
               {"evaluations", "evaluations", ">11.4f", &ParameterRow::evaluations},
               {"evaluations_max", "most", ">9", &ParameterRow::evaluations_max},
               {"not_converged", "failed", ">7", &ParameterRow::not_converged},
               {"iteration_limit", "at limit", ">8", &ParameterRow::iteration_limit},
               {"error_p99_clearances", "error 99 %", ">12.2g", &ParameterRow::error_p99},
               {"error_max_clearances", "error most", ">12.2g", &ParameterRow::error_max}},
              bench_parameters(a.seed, a.scenes, scenes_of(a), watched("parameters")),
              "evaluations: of the potential, per step; error: of a step against a strict one from "
              "the same state, in clearances\n");
}

Told turns(const BenchArguments& a) {
  return told({{"scene", "scene", "<10", &TurnRow::scene},
               {"motion", "motion", "<10", &TurnRow::motion},
               {"turned_90", "turned by 90", ">13.2g", &TurnRow::quarter},
               {"turned_37", "by 37 deg", ">12.2g", &TurnRow::any},
               {"mirrored", "mirrored", ">12.2g", &TurnRow::mirrored},
               {"starts", "starts", ">12", &TurnRow::starts},
               {"off", "off by 1e-6", ">12", &TurnRow::off}},
              bench_turns(a.seed, a.scenes, watched("turns")));
}

Told parts(const BenchArguments& a) {
  return told({{"scene", "scene", "<10", &PartRow::scene},
               {"part", "with", "<20", &PartRow::part},
               {"controller", "controller", "<18", &PartRow::controller},
               {"trials", "", "", &PartRow::trials},
               {"inserted", "", "", &PartRow::inserted},
               {"low", "", "", [](auto& r) { return r.interval.low; }},
               {"high", "", "", [](auto& r) { return r.interval.high; }},
               {"", "inserted", ">12",
                [](auto& r) { return fmt::format("{} of {}", r.inserted, r.trials); }},
               {"", "95 % [%]", ">18",
                [](auto& r) {
                  return fmt::format("{:.1f} to {:.1f}", 100 * r.interval.low,
                                     100 * r.interval.high);
                }}},
              bench_parts(a.seed, a.trials, scenes_of(a), watched("campaigns")));
}

std::string count_and_interval(std::size_t count, const Interval& i) {
  return fmt::format("{} ({:.1f} to {:.1f} %)", count, 100 * i.low, 100 * i.high);
}
Columns<PlanRow> plan_columns() {
  return {{"scene", "scene", "<10", &PlanRow::scene},
          {"planning_s", "plan [s]", ">8.2f", &PlanRow::planning_s},
          {"error_bound", "bound", ">9.2g", &PlanRow::error_bound, "inf"},
          {"sampled_twice", "sampled twice", ">14.2g", &PlanRow::sampled_twice},
          {"full_us_per_simulated_s", "full", ">10.0f", &PlanRow::full_us_per_simulated_s},
          {"shipped_us_per_simulated_s", "shipped", ">10.0f", &PlanRow::shipped_us_per_simulated_s},
          {"planned_us_per_simulated_s", "planned", ">10.0f", &PlanRow::planned_us_per_simulated_s},
          {"ratio", "ratio", ">6.2f", &PlanRow::ratio},
          {"trials", "trials", ">7", &PlanRow::trials},
          {"full_inserted", "", "", &PlanRow::full_inserted},
          {"full_low", "", "", [](auto& r) { return r.full_interval.low; }},
          {"full_high", "", "", [](auto& r) { return r.full_interval.high; }},
          {"planned_inserted", "", "", &PlanRow::planned_inserted},
          {"planned_low", "", "", [](auto& r) { return r.planned_interval.low; }},
          {"planned_high", "", "", [](auto& r) { return r.planned_interval.high; }},
          {"", "full inserted", ">24",
           [](auto& r) { return count_and_interval(r.full_inserted, r.full_interval); }},
          {"", "planned inserted", ">24",
           [](auto& r) { return count_and_interval(r.planned_inserted, r.planned_interval); }}};
}

Told plans(const BenchArguments& a) {
  return told(plan_columns(), bench_plans(a.seed, a.trials, scenes_of(a), watched("campaigns")),
              "full (every step solved), shipped, planned: us of the processor per simulated s of "
              "a campaign\n");
}

Told sensors(const BenchArguments& a) {
  return told({{"scene", "scene", "<10", &SensorRow::scene},
               {"sensor", "sensor", "<32", &SensorRow::sensor},
               {"trials", "", "", &SensorRow::trials},
               {"inserted", "", "", &SensorRow::inserted},
               {"", "inserted", ">12",
                [](auto& r) { return fmt::format("{} of {}", r.inserted, r.trials); }}},
              bench_sensors(a.seed, a.trials, scenes_of(a), watched("sensors")),
              "inserted by the law of 20 demonstrations, of the pairs of parts that fit; errors as "
              "parts of the force limit; none: straight in at constant velocity\n");
}

Told peers(const BenchArguments&) {
  const PeerBench bench = bench_peers(watched("engines"));
  for (const std::string& missing : bench.missing)
    fmt::print(stderr, "ferrule: not measured: {}\n", missing);
  Told all = told(
      {{"engine", "engine", "<8", &PeerRow::engine},
       {"version", "version", "<8", &PeerRow::version},
       {"segments", "", "", &PeerRow::segments},
       {"", "segments", ">8",
        [](auto& r) { return r.segments ? fmt::format("{}", r.segments) : "round"; }},
       {"step_s", "step [s]", ">8g", &PeerRow::step_s},
       {"us_per_simulated_ms", "us per ms", ">9.3g", &PeerRow::us_per_simulated_ms},
       {"pose_error_um", "pose [um]", ">10.3g", &PeerRow::pose_error_um, "diverged"},
       {"force_error_relative", "force error", ">11.2g", &PeerRow::force_error_relative,
        "diverged"},
       {"penetration_um", "penetr.[um]", ">11.3g", &PeerRow::penetration_um, "diverged"},
       {"outside", "", "", &PeerRow::outside},
       {"let_in", "", "", &PeerRow::let_in},
       {"", "let in", ">8", [](auto& r) { return fmt::format("{} of {}", r.let_in, r.outside); }},
       {"settings", "settings", "", &PeerRow::settings}},
      bench.rows,
      "pose, force and penetration: largest error in the motion, clearance 0.5 um; let in: "
      "of fibres that start beside a sharp bore\n");
  all.json["not_measured"] = bench.missing;
  return all;
}

// Which options a benchmark has.
struct BenchOptions {
  std::size_t draws = 0;  // --scenes: how many unless given; 0: it has none
  bool scene = false, trials = false;

  bool seed() const { return draws > 0 || trials; }
};
constexpr BenchOptions kTrials{.scene = true, .trials = true};

struct Benchmark {
  const char* name;  // "": what is run unless one is named
  const char* help;
  Told (*run)(const BenchArguments& a);
  BenchOptions options{};
};

constexpr std::size_t kDraws = 200;
constexpr Benchmark kBenchmarks[] = {
    {"", "laws, stepping, campaigns and controllers", speed_and_error},
    {"hard", "the hard cases", hard},
    {"capture", "from how far off the axis an end goes in", capture},
    {"tail", "the worst steps", tail, {.draws = kDraws}},
    {"events", "the same motions at ever finer steps", events, {.draws = 2, .scene = true}},
    {"turns", "the same turned about the axis, and mirrored", turns, {.draws = kDraws}},
    {"parameters",
     "the solver's, each halved and doubled",
     parameters,
     {.draws = 1, .scene = true}},
    {"peers", "other engines in the same motion", peers},
    {"recording", "the cost of a row", recording},
    {"parts", "success with curl, cleave, edge and the like", parts, kTrials},
    {"plans", "planned against full campaigns", plans, kTrials},
    {"sensors", "success against noise and bias of the force sensor", sensors, kTrials}};

// Every benchmark makes its own scenes of one that ships, those with a seed draw motions in shipped
// scenes too. Partial where Ctrl-C ended it.
Provenance provenance_of(const Benchmark& benchmark, const BenchArguments& a) {
  Provenance provenance;
  provenance.read(scene_file("paper"));
  if (interrupted()) provenance.partial("the cases as far as they were run");
  if (!benchmark.options.seed()) return provenance;
  for (const std::string& name : benchmark.options.scene ? scenes_of(a) : shipped_scenes())
    if (name != "paper") provenance.read(scene_file(name));
  return provenance.seed("scenes, starts and motions", a.seed);
}

int bench_verb(BenchArguments a) {
  if (!a.what.empty() && !a.plot.empty())
    throw BadInput("--plot: there is nothing to draw of bench " + a.what);
  const Benchmark& benchmark = *std::find_if(std::begin(kBenchmarks), std::end(kBenchmarks),
                                             [&](const Benchmark& b) { return b.name == a.what; });
  if (a.scenes == 0) a.scenes = benchmark.options.draws;
  const Told found = benchmark.run(a);
  const Provenance provenance = provenance_of(benchmark, a);
  if (a.output.text()) fmt::print("{}{}", found.text, provenance.foot());
  print_result(a.output, found.json, "rows", provenance);
  return interrupted() ? kInterrupted : found.passed ? kDone : kFailed;
}

// "a, b and c"
std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 < words.size() ? ", " : " and ") + words[i];
  return text;
}

// Names of the benchmarks that have an option.
template <class Has>
std::string those_with(Has has) {
  std::vector<std::string> names;
  for (const Benchmark& b : kBenchmarks)
    if (std::invoke(has, b.options)) names.push_back(b.name);
  return listed(names);
}

void add_bench(CLI::App& verb, Run& run) {
  auto a = std::make_shared<BenchArguments>();
  std::vector<std::string> names, help, draws{std::to_string(kDraws)};
  for (const Benchmark& b : kBenchmarks) {
    help.push_back(fmt::format("{}: {}", *b.name ? b.name : "Unless given", b.help));
    if (*b.name) names.push_back(b.name);
    if (b.options.draws > 0 && b.options.draws != kDraws)
      draws.push_back(fmt::format("{} for {}", b.options.draws, b.name));
  }
  verb.add_option("what", a->what, fmt::format("{}", fmt::join(help, "; ")))->check(one_of(names));
  add_seed(verb, a->seed,
           "Seed of the scenes, starts, motions and trials of " + those_with(&BenchOptions::seed));
  verb.add_option(
          "--scene", a->scene,
          "Scene of " + those_with(&BenchOptions::scene) + "; all shipped ones unless given")
      ->type_name("SCENE");
  verb.add_option("--trials", a->trials,
                  "Trials of each controller in each scene of " + those_with(&BenchOptions::trials))
      ->check(whole_number(1, 1000000))
      ->capture_default_str();
  verb.add_option(
          "--scenes", a->scenes,
          fmt::format("Random scenes, and starts in shipped scenes, of {}; {}, unless given",
                      those_with(&BenchOptions::draws), listed(draws)))
      ->check(whole_number(1, 1000000));
  verb.add_option("--plot", a->plot, "Draw work-precision plots into a folder")->type_name("DIR");
  add_output(verb, a->output);
  add_examples(verb, {"bench --plot pictures", "bench hard --json", "bench peers"});
  verb.callback([a, &run] { run.verb = [a] { return bench_verb(*a); }; });
}

}  // namespace

extern "C" {
extern const AddOptions ferrule_loaded_verb;
const AddOptions ferrule_loaded_verb = &add_bench;
}

}  // namespace ferrule
