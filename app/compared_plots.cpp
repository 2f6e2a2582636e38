#include <fmt/format.h>

#include <map>
#include <set>

#include "app/compare_plot.hpp"
#include "app/compared.hpp"
#include "app/failures.hpp"
#include "app/html.hpp"
#include "capture/episode.hpp"
#include "controller/campaign_table.hpp"

namespace ferrule {
namespace {

std::string file_of(const std::string& name) {
  std::string file;
  for (const char c : name)
    if (c != ',') file += c == ' ' || c == '/' ? '_' : c;
  return file + ".svg";
}

// The rungs, each with the whole controllers whose success something decides: of what was trained
// with several seeds the first.
std::map<std::string, std::vector<LadderRow>> decided_by_rung(
    const std::vector<LadderRow>& ladder) {
  std::map<std::string, std::vector<LadderRow>> rungs;
  std::set<std::pair<std::string, std::string>> seen;
  for (const LadderRow& row : ladder)
    if (row.without.empty() && seen.insert({row.rung, row.controller}).second &&
        !row.deciding.tenths.empty())
      rungs[row.rung].push_back(row);
  return rungs;
}

// Which force acted when in what was learned from.
NamedHistory forces_of(const DemonstrationSet& set) {
  std::vector<InsertionForces> forces;
  for (const Demonstration& d : set.demonstrations) {
    const Episode episode = read_episode(d.file);
    forces.emplace_back(episode, recorded_scene(episode.info, d.file));
  }
  return {fmt::format("{} demonstrations", forces.size()), force_history(std::move(forces))};
}

}  // namespace

void write_plots(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
                 const Found& found, const std::vector<Vector2d>& starts,
                 const Provenance& provenance) {
  const auto drawn = [&](const std::string& name, const Plot& plot) {
    write_svg(a.plot + "/" + file_of(name), plot);
    return figure(plot, "");
  };
  std::vector<ReplayRun> runs;
  std::vector<TrialMap> maps;
  std::vector<NamedHistory> forces{forces_of(set)};
  std::string maps_drawn, table;
  for (const Entry& e : found.entries) {
    const char* against = e.name == "constant velocity" ? "constant-velocity"
                          : e.name == kTeacher          ? "operator"
                                                        : nullptr;
    const std::string command =
        against ? fmt::format("./ferrule view --trial TRIAL --against {}{} --seed {}{}", against,
                              SceneArguments{scene.name, a.scene.settings}.given(), a.seed,
                              e.name == kTeacher ? fmt::format(" --skill {}", a.skill.text()) : "")
                : "";
    const TestedController tested{e.name, command, e.make, &e.results};
    add_failures(scene, a.seed, tested, runs, maps);
    forces.push_back(forces_of_trials(scene, a.seed, tested));
    maps_drawn += drawn("map_" + e.name, failure_map(e.name, e.results, starts));
    table += to_text(e.name, e.alone);
  }
  std::string html =
      replay_head("ferrule: ways to insert") + "<h1>Ways to insert, on the same trials</h1>\n" +
      replay_section("trials that failed", runs, maps) + "<pre>" + escaped(table) + "</pre>\n" +
      drawn("misalignment", misalignment_plot(found.entries)) + to_html(forces) + maps_drawn;
  if (!found.learning.empty()) html += drawn("demonstrations", learning_plot(found.learning));
  for (const auto& [name, rung] : decided_by_rung(found.ladder))
    html += drawn(name, rung_plot(rung));
  write_text(a.plot + "/report.html", html + "<p>" + escaped(provenance.head()) + "</p>\n<p>" +
                                          escaped(provenance.foot()) + "</p>\n</body></html>\n");
}

}  // namespace ferrule
