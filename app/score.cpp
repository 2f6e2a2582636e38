// ferrule score: how good each insertion of a folder was, for trainers of operators.
#include "capture/score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/plot.hpp"
#include "app/verb.hpp"
#include "sim/content_hash.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

struct ScoreArguments {
  std::string folder, plot;
  bool one_operator = false;
  Output output;
};

struct Unit {
  const char* key;
  const char* heading;
  double factor;
};
// In the order of the parts.
constexpr std::array<Unit, kParts> kUnits = {{{"time_s", "time_s", 1},
                                              {"peak_force_uN", "peak_uN", 1e6},
                                              {"mean_force_uN", "mean_uN", 1e6},
                                              {"friction_work_pJ", "work_pJ", 1e12},
                                              {"smoothness", "smooth", -1},
                                              {"corrections", "correct", 1},
                                              {"contact_time_s", "contact_s", 1}}};

struct Scored {
  std::string file, operator_, scene;
  Measures measures;
  std::size_t group = 0;
  Score score{};
};

// Episodes that can be set side by side: of one operator in one scene.
struct Group {
  std::string operator_, scene;
  Json document;
  std::vector<std::size_t> episodes;  // places in the list of all

  std::string title() const { return operator_ + ", scene " + scene; }
};

struct Session {
  std::vector<Scored> all;
  std::vector<Group> groups;
  bool scored = false;  // did any episode succeed?
};

// The group of an episode; a new one where there is none yet.
std::size_t group_of(const Scored& episode, const Json& document, std::vector<Group>& groups) {
  const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
    return g.operator_ == episode.operator_ && g.document == document;
  });
  const auto place = static_cast<std::size_t>(same - groups.begin());
  if (same == groups.end()) groups.push_back({episode.operator_, episode.scene, document, {}});
  return place;
}

// Scores every episode against the best of its group.
Session scored(const ScoreArguments& a, Provenance& provenance) {
  Session session;
  const std::string& folder = a.folder;
  const std::vector<std::string> files = episode_files(folder);
  Progress progress("reading", files.size());
  for (const std::string& file : files) {
    if (interrupted()) break;
    const Episode episode = read_episode(file);
    provenance.read(file);
    const Scene scene = recorded_scene(episode, file);
    Scored& now = session.all.emplace_back(
        Scored{file, episode.info.operator_, scene.name, measure(episode, scene)});
    if (a.one_operator) now.operator_ = session.all.front().operator_;
    now.group = group_of(now, undrawn(scene.document), session.groups);
    session.groups[now.group].episodes.push_back(session.all.size() - 1);
    progress(session.all.size());
  }
  if (interrupted()) {
    if (session.all.empty()) throw Stopped();
    provenance.partial(fmt::format("{} of {} episodes", session.all.size(), files.size()));
  }
  if (session.all.empty()) throw BadInput(folder + ": no episodes in it");
  for (const Group& group : session.groups) {
    std::vector<Measures> measures;
    for (const std::size_t i : group.episodes) measures.push_back(session.all[i].measures);
    const std::vector<Score> scores = score(measures);
    for (std::size_t i = 0; i < scores.size(); ++i)
      session.all[group.episodes[i]].score = scores[i];
    session.scored |= std::isfinite(scores[0].total);
  }
  return session;
}

Plot learning_curve(const Session& session) {
  Axes total{"", "score", false, false, {}}, parts{"episode", "100 best / own", false, false, {}};
  const bool several = session.groups.size() > 1;
  for (const Group& group : session.groups) {
    const std::string of = several ? ", " + group.title() : "";
    Series inserted{"inserted" + of, {}, {}, Series::points_on_line};
    Series others{"not inserted" + of, {}, {}, Series::points};
    std::vector<double> number;
    for (const std::size_t i : group.episodes) {
      number.push_back(static_cast<double>(i) + 1);
      const Scored& episode = session.all[i];
      Series& series = episode.measures.outcome == Outcome::inserted ? inserted : others;
      series.x.push_back(number.back());
      series.y.push_back(episode.score.total);
    }
    for (const Series& series : {inserted, others})
      if (!series.x.empty() || !several) total.series.push_back(series);
    for (std::size_t part = 0; part < kParts && !several; ++part) {
      Series series{kPartNames[part], number, {}, Series::points_on_line};
      for (const std::size_t i : group.episodes)
        series.y.push_back(100 * session.all[i].score.parts[part]);
      parts.series.push_back(series);
    }
  }
  if (!several) return {"Score over the episodes", {total, parts}, 860, 320};
  total.x_label = "episode";
  return {"Score over the episodes, each against the best of its operator in its scene",
          {total},
          860,
          420};
}

Json to_json(const Scored& episode) {
  const Measures& m = episode.measures;
  Json json = {{"file", episode.file},
               {"operator", episode.operator_},
               {"scene", episode.scene},
               {"group", episode.group + 1},
               {"outcome", name(m.outcome)},
               {"completion", m.completion},
               {"score", number_or_null(episode.score.total)}};
  for (std::size_t part = 0; part < kParts; ++part) {
    json[kUnits[part].key] = kUnits[part].factor * m.parts[part];
    json["parts"][kPartNames[part]] = number_or_null(episode.score.parts[part]);
  }
  return json;
}

void print_group(const Session& session, const Group& group) {
  fmt::print("{}: {} episodes\n{:<20} {:<14} {:>6}", group.title(), group.episodes.size(),
             "episode", "outcome", "score");
  for (const Unit& unit : kUnits) fmt::print(" {:>9}", unit.heading);
  fmt::print("\n");
  for (const std::size_t i : group.episodes) {
    const Scored& episode = session.all[i];
    fmt::print("{:<20} {:<14} {:>6}", std::filesystem::path(episode.file).filename().string(),
               name(episode.measures.outcome), number_or("-", "{:.1f}", episode.score.total));
    for (std::size_t part = 0; part < kParts; ++part)
      fmt::print(" {:>9.4g}", kUnits[part].factor * episode.measures.parts[part]);
    fmt::print("\n");
  }
  if (!std::isfinite(session.all[group.episodes[0]].score.total))
    fmt::print("no episode succeeded: there is no best to score against\n");
}

void print(const Session& session) {
  if (session.groups.size() > 1)
    fmt::print("{} operators and scenes: each episode is scored against the best of its own\n",
               session.groups.size());
  for (const Group& group : session.groups) print_group(session, group);
}

int score_verb(const ScoreArguments& a) {
  watch_for_interrupt();
  Provenance provenance;
  const Session session = scored(a, provenance);
  if (!a.plot.empty()) {
    if (!session.scored)
      throw BadInput(a.folder + ": no episode succeeded: there is no score to draw");
    write_plot(a.plot, learning_curve(session));
  }
  if (a.output.text()) {
    print(session);
    fmt::print("{}", provenance.foot());
  }
  const Json groups = json_list(session.groups, [](const Group& g) {
    return Json{{"operator", g.operator_},
                {"scene", g.scene},
                {"scene_sha1", sha1(g.document.dump())},
                {"episodes", g.episodes.size()}};
  });
  print_result(a.output,
               {{"folder", a.folder},
                {"groups", groups},
                {"episodes", json_list(session.all, [](const Scored& e) { return to_json(e); })}},
               "episodes", provenance);
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_score(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("score", "How good each recorded insertion was");
  auto a = std::make_shared<ScoreArguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes")->required()->type_name("DIR");
  verb->add_option("--plot", a->plot, "Draw score and parts over the episodes")
      ->type_name("FILE.svg");
  verb->add_flag("--one-operator", a->one_operator,
                 "All episodes are by one person, whatever they call him: one learning curve");
  add_output(*verb, a->output);
  add_examples(*verb, {"score episodes", "score episodes --plot learning.svg --csv"});
  verb->callback([a, &run] { run = [a] { return score_verb(*a); }; });
}

}  // namespace ferrule
