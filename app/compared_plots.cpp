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

// By rung: what decides the success of whom. Of what was trained with several seeds the first; of
// who is not whole nothing.
std::map<std::string, std::vector<std::pair<std::string, Deciding>>> decided_by_rung(
    const std::vector<LadderRow>& ladder) {
  std::map<std::string, std::vector<std::pair<std::string, Deciding>>> rungs;
  std::set<std::pair<std::string, std::string>> seen;
  for (const LadderRow& row : ladder)
    if (row.without.empty() && seen.insert({row.rung, row.controller}).second &&
        !row.deciding.tenths.empty())
      rungs[row.rung].emplace_back(row.controller, row.deciding);
  return rungs;
}

void draw(const std::string& folder, const Found& found, const std::vector<Vector2d>& starts) {
  std::vector<std::pair<std::string, std::vector<Ring>>> rings;
  for (const Entry& e : found.entries) {
    rings.emplace_back(e.candidate.name, e.rings);
    write_svg(folder + "/map_" + file_of(e.candidate.name),
              failure_map(e.candidate.name, e.results, starts));
  }
  write_svg(folder + "/misalignment.svg", misalignment_plot(rings));
  if (!found.learning.empty())
    write_svg(folder + "/demonstrations.svg", learning_plot(found.learning));
  for (const auto& [rung, controllers] : decided_by_rung(found.ladder))
    write_svg(folder + "/" + file_of(rung), rung_plot(rung, controllers));
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

// All of it in one page, on which trials that failed can be watched.
void write_report(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
                  const Found& found, const std::vector<Vector2d>& starts,
                  const Provenance& provenance) {
  std::vector<ReplayRun> runs;
  std::vector<TrialMap> maps;
  std::vector<NamedHistory> forces{forces_of(set)};
  std::string maps_drawn, table;
  std::vector<std::pair<std::string, std::vector<Ring>>> rings;
  for (const Entry& e : found.entries) {
    const std::string& who = e.candidate.name;
    const char* against = who == "constant velocity" ? "constant-velocity"
                          : who == kTeacher          ? "operator"
                                                     : nullptr;
    const std::string command =
        against ? fmt::format("./ferrule view --trial TRIAL --against {}{} --seed {}{}", against,
                              SceneArguments{scene.name, a.scene.settings}.given(), a.seed,
                              who == kTeacher ? fmt::format(" --skill {}", a.skill.text()) : "")
                : "";
    const TestedController tested{who, command, e.candidate.make, &e.results};
    add_failures(scene, a.seed, tested, runs, maps);
    forces.push_back(forces_of_trials(scene, a.seed, tested));
    maps_drawn += figure(failure_map(who, e.results, starts), "");
    rings.emplace_back(who, e.rings);
    table += to_text(who, e.alone);
  }
  std::string html =
      replay_head("ferrule: ways to insert") + "<h1>Ways to insert, on the same trials</h1>\n" +
      replay_section("trials that failed", runs, maps) + "<pre>" + escaped(table) + "</pre>\n" +
      figure(misalignment_plot(rings), "") + to_html(forces) + maps_drawn;
  if (!found.learning.empty()) html += figure(learning_plot(found.learning), "");
  for (const auto& [rung, controllers] : decided_by_rung(found.ladder))
    html += figure(rung_plot(rung, controllers), "");
  write_text(a.plot + "/report.html", html + "<p>" + escaped(provenance.head()) + "</p>\n<p>" +
                                          escaped(provenance.foot()) + "</p>\n</body></html>\n");
}

}  // namespace

void write_plots(const CompareArguments& a, const Scene& scene, const DemonstrationSet& set,
                 const Found& found, const std::vector<Vector2d>& starts,
                 const Provenance& provenance) {
  draw(a.plot, found, starts);
  write_report(a, scene, set, found, starts, provenance);
}

}  // namespace ferrule
