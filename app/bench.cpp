// ferrule bench: speed against error.
#include <fmt/format.h>

#include <map>
#include <tuple>

#include "app/plot.hpp"
#include "app/verb.hpp"
#include "bench/capture.hpp"
#include "bench/controllers.hpp"
#include "bench/hard.hpp"
#include "bench/laws.hpp"
#include "bench/stepping.hpp"

namespace ferrule {
namespace {

struct Arguments {
  std::string what, plot;
  bool json = false;
};

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

int speed_and_error(const Arguments& a) {
  const std::vector<LawRow> laws = bench_laws();
  const std::vector<SteppingRow> stepping = bench_stepping();
  const std::vector<ControllerRow> controllers = bench_controllers();
  if (!a.plot.empty()) {
    make_plot_folder(a.plot);
    write_svg(a.plot + "/laws.svg",
              work_precision(
                  "Force laws: cost against error", "ns per evaluation", "largest relative error",
                  laws, series_of, [](const LawRow& r) { return r.relative_error; },
                  [](const LawRow& r) { return r.ns; }));
    write_svg(a.plot + "/stepping.svg",
              work_precision(
                  "Stepping: cost against error", "us per simulated second", "tip error [nm]",
                  stepping, [](const SteppingRow& r) { return r.method + ", " + r.scene_case; },
                  // What is exact to rounding would only stretch the axis.
                  [](const SteppingRow& r) { return r.tip_error_nm > 1e-6 ? r.tip_error_nm : NAN; },
                  [](const SteppingRow& r) { return r.us_per_simulated_s; }));
    fmt::print(stderr, "wrote {0}/laws.svg and {0}/stepping.svg\n", a.plot);
  }
  if (a.json) {
    Json l = Json::array(), s = Json::array(), c = Json::array();
    for (const LawRow& r : laws)
      l.push_back({{"name", r.name},
                   {"fidelity", r.fidelity},
                   {"ns", r.ns},
                   {"relative_error", r.relative_error}});
    for (const SteppingRow& r : stepping)
      s.push_back({{"method", r.method},
                   {"case", r.scene_case},
                   {"step_s", r.step_s},
                   {"ns_per_step", r.ns_per_step},
                   {"us_per_simulated_s", r.us_per_simulated_s},
                   {"tip_error_nm", number_or_null(r.tip_error_nm)},
                   {"force_error_relative", number_or_null(r.force_error_relative)},
                   {"newton_iterations", r.newton_iterations},
                   {"not_converged", r.not_converged},
                   {"halvings", r.halvings}});
    for (const ControllerRow& r : controllers)
      c.push_back({{"name", r.name},
                   {"shape", r.shape},
                   {"ns", r.ns},
                   {"relative_error", r.relative_error}});
    print_json({{"laws", l}, {"stepping", s}, {"controllers", c}});
    return kDone;
  }
  fmt::print("{:<15} {:<42} {:>9} {:>15}\n", "law", "fidelity", "ns", "relative error");
  for (const LawRow& r : laws)
    fmt::print("{:<15} {:<42} {:9.1f} {:15.2g}\n", r.name, r.fidelity, r.ns, r.relative_error);
  fmt::print("\n{:<15} {:<26} {:>9} {:>11} {:>16} {:>13} {:>12} {:>9} {:>7} {:>7}\n", "method",
             "case", "step [s]", "ns per step", "us per simul. s", "tip err. [nm]", "force error",
             "Newton/st", "failed", "halved");
  for (const SteppingRow& r : stepping)
    fmt::print("{:<15} {:<26} {:9.0e} {:11.0f} {:16.4g} {:>13} {:>12} {:>9.2f} {:>7} {:>7}\n",
               r.method, r.scene_case, r.step_s, r.ns_per_step, r.us_per_simulated_s,
               std::isfinite(r.tip_error_nm) ? fmt::format("{:.3g}", r.tip_error_nm) : "diverged",
               std::isfinite(r.tip_error_nm) ? fmt::format("{:.2g}", r.force_error_relative) : "-",
               r.newton_iterations, r.not_converged, r.halvings);
  fmt::print("\n{:<15} {:<42} {:>9} {:>15}\n", "controller", "shape", "ns", "relative error");
  for (const ControllerRow& r : controllers)
    fmt::print("{:<15} {:<42} {:9.1f} {:15.2g}\n", r.name, r.shape, r.ns, r.relative_error);
  return kDone;
}

int hard(const Arguments& a) {
  const std::vector<HardRow> rows = bench_hard();
  std::size_t failed = 0;
  Json list = Json::array();
  if (!a.json)
    fmt::print("{:<62} {:>8} {:>9} {:<7} {}\n", "case", "step [s]", "error", "status", "result");
  for (const HardRow& r : rows) {
    const char* status = !r.finite ? "NaN" : r.gained ? "gained" : r.passed() ? "ok" : "wrong";
    failed += !r.passed();
    list.push_back({{"case", r.name},
                    {"step_s", number_or_null(r.step_s)},
                    {"result", r.result},
                    {"error", number_or_null(r.error)},
                    {"status", status}});
    if (!a.json)
      fmt::print("{:<62} {:>8} {:9.2g} {:<7} {}\n", r.name,
                 std::isfinite(r.step_s) ? fmt::format("{:g}", r.step_s) : "-", r.error, status,
                 r.result);
  }
  if (a.json) print_json({{"rows", list}});
  return failed ? kFailed : kDone;
}

int capture(const Arguments& a) {
  const std::vector<CaptureRow> rows = bench_capture();
  std::size_t wrong = 0;
  // By lead-in, offset and what must be.
  std::map<std::tuple<bool, double, bool>, std::pair<std::size_t, std::size_t>> counts;
  Json list = Json::array();
  for (const CaptureRow& r : rows) {
    wrong += r.inserted != r.expected();
    auto& [in, all] = counts[{r.lead_in, r.offset_clearances, r.expected()}];
    in += r.inserted;
    ++all;
    list.push_back({{"offset_clearances", r.offset_clearances},
                    {"capture_clearances", r.capture_clearances},
                    {"direction_deg", r.direction_deg},
                    {"speed_um_s", r.speed_um_s},
                    {"step_s", r.step_s},
                    {"lead_in", r.lead_in},
                    {"inserted", r.inserted}});
  }
  if (a.json) {
    print_json({{"rows", list}, {"wrong", wrong}});
    return wrong ? kFailed : kDone;
  }
  fmt::print("{:<12} {:>10} {:>12} {:>12}\n", "mouth", "offset", "must go in", "inserted");
  for (const auto& [key, count] : counts)
    fmt::print("{:<12} {:>10.5g} {:>12} {:>12}\n", std::get<0>(key) ? "lead-in" : "sharp",
               std::get<1>(key), std::get<2>(key) ? "yes" : "no",
               fmt::format("{} of {}", count.first, count.second));
  fmt::print(
      "offsets in clearances; a sharp bore takes those below 1, a lead-in those below {:.5g}, its "
      "rim\n{} of {} wrong\n",
      rows.back().capture_clearances, wrong, rows.size());
  return wrong ? kFailed : kDone;
}

}  // namespace

void add_bench(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("bench", "Speed against error of laws, stepping and controllers; capture");
  auto a = std::make_shared<Arguments>();
  verb->add_option("what", a->what,
                   "Nothing: laws, stepping and controllers; hard: the hard cases; capture: "
                   "clearance means clearance")
      ->check(CLI::IsMember({"hard", "capture"}));
  verb->add_option("--plot", a->plot, "Draw work-precision plots into a folder")->type_name("DIR");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] {
    run = [a] {
      if (!a->what.empty() && !a->plot.empty())
        throw BadInput("--plot: there is nothing to draw of bench " + a->what);
      return a->what == "hard"      ? hard(*a)
             : a->what == "capture" ? capture(*a)
                                    : speed_and_error(*a);
    };
  });
}

}  // namespace ferrule
