// ferrule score: how good each insertion of a folder was, for trainers of operators.
#include "capture/score.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/plot.hpp"
#include "app/progress.hpp"
#include "app/verbs.hpp"
#include "capture/episode_copies.hpp"
#include "controller/statistics.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

struct ScoreArguments {
  std::vector<std::string> places;
  std::string plot;
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
  std::string file, operator_, scene, date, session;
  int rating;
  Measures measures;
  std::size_t group = 0;
  std::optional<Score> score{};  // empty: the scene has no yardstick

  double total() const { return score ? score->total : NAN; }
  double part(std::size_t i) const { return score ? score->parts[i] : NAN; }
};

// Episodes that can be set side by side: of one operator in one scene.
struct Group {
  std::string operator_, scene;
  Json document;
  std::optional<Yardstick> yardstick;
  std::vector<std::size_t> episodes;  // places in the list of all

  std::string title() const {
    return printable(operator_, 100) + ", scene " + printable(scene, 100);
  }
};

struct Scores {
  std::vector<Scored> all;
  std::vector<Group> groups;
  bool scored = false;  // is there any score?
};

// The group of an episode; a new one where there is none yet.
std::size_t group_of(const Scored& episode, const Json& document, std::vector<Group>& groups) {
  const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
    return g.operator_ == episode.operator_ && g.document == document;
  });
  const auto place = static_cast<std::size_t>(same - groups.begin());
  if (same != groups.end()) return place;
  const auto measured = std::find_if(groups.begin(), groups.end(),
                                     [&](const Group& g) { return g.document == document; });
  const std::optional<Yardstick> fixed = measured != groups.end()
                                             ? measured->yardstick
                                             : yardstick(parse_scene(document, episode.file));
  groups.push_back({episode.operator_, episode.scene, document, fixed, {}});
  return place;
}

// Persons and folders can be set side by side in one scene alone.
void refuse_mixed_scenes(const Scores& session) {
  for (const Group& group : session.groups)
    if (group.document != session.groups.front().document)
      throw BadInput(
          fmt::format("{} is of another scene ({}) than {} ({}): scores compare within one scene",
                      session.all[group.episodes.front()].file, group.scene,
                      session.all.front().file, session.groups.front().scene));
}

// Who inserted: the trainee's name where the episode has it, under whatever device.
std::string person(const EpisodeInfo& info) {
  return info.trainee.empty() ? info.operator_ : info.trainee;
}

// Scores every episode against the yardstick of its scene.
Scores scored(const ScoreArguments& a, Provenance& provenance) {
  Scores session;
  const std::vector<std::string> files = episode_files(a.places);
  Progress progress("reading", files.size());
  EpisodeCopies copies;
  for (const std::string& file : files) {
    if (interrupted()) break;
    const EpisodeRows episode = open_episode(file);
    if (const auto copy = copies.seen(episode, file)) {
      fmt::print(stderr, "note: {}\n", printable(copy->text()));
      continue;
    }
    provenance.read(file);
    const EpisodeInfo& info = episode.info();
    const Scene scene = recorded_scene(info, file);
    Scored& now =
        session.all.emplace_back(Scored{file, person(info), scene.name, info.date, info.session,
                                        info.rating, measure(episode, scene)});
    if (a.one_operator) now.operator_ = session.all.front().operator_;
    now.group = group_of(now, undrawn(scene.document()), session.groups);
    Group& group = session.groups[now.group];
    group.episodes.push_back(session.all.size() - 1);
    if (group.yardstick) now.score = score(now.measures, *group.yardstick);
    session.scored |= now.score.has_value();
    progress(session.all.size());
  }
  if (interrupted()) {
    if (session.all.empty()) throw Stopped();
    provenance.partial(fmt::format("{} of {} episodes", session.all.size(), files.size()));
  }
  if (session.all.empty())
    throw BadInput(fmt::format("{}: no episodes in it", fmt::join(a.places, " ")));
  if (a.places.size() > 1) refuse_mixed_scenes(session);
  return session;
}

Plot learning_curve(const Scores& session) {
  Axes total{"", "score", false, false, {}},
      parts{"episode", "100 yardstick / own", false, false, {}};
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
      series.y.push_back(episode.total());
    }
    for (const Series& series : {inserted, others})
      if (!series.x.empty() || !several) total.series.push_back(series);
    for (std::size_t part = 0; part < kParts && !several; ++part) {
      Series series{kPartNames[part], number, {}, Series::points_on_line};
      for (const std::size_t i : group.episodes)
        series.y.push_back(100 * session.all[i].part(part));
      parts.series.push_back(series);
    }
  }
  if (!several) return {"Score over the episodes", {total, parts}, 860, 320};
  total.x_label = "episode";
  return {"Score over the episodes, each against the yardstick of its scene", {total}, 860, 420};
}

Json to_json(const Scored& episode) {
  const Measures& m = episode.measures;
  Json json = {{"file", episode.file},
               {"operator", episode.operator_},
               {"scene", episode.scene},
               {"group", episode.group + 1},
               {"outcome", name(m.outcome)},
               {"completion", m.completion},
               {"score", number_or_null(episode.total())},
               {"hint", episode.score ? hint(m, *episode.score) : ""}};
  if (!episode.date.empty()) json["date"] = episode.date;
  if (!episode.session.empty()) json["session"] = episode.session;
  if (episode.rating) json["rating"] = episode.rating;
  for (std::size_t part = 0; part < kParts; ++part) {
    json[kUnits[part].key] = kUnits[part].factor * m.parts[part];
    json["parts"][kPartNames[part]] = number_or_null(episode.part(part));
  }
  return json;
}

Json yardstick_json(const Yardstick& yardstick) {
  Json json;
  for (std::size_t part = 0; part < kParts; ++part)
    json[kUnits[part].key] = kUnits[part].factor * yardstick.parts[part];
  return json;
}

void print_group(const Scores& session, const Group& group) {
  fmt::print("{}: {} episodes\n{:<20} {:<14} {:>6}", group.title(), group.episodes.size(),
             "episode", "outcome", "score");
  for (const Unit& unit : kUnits) fmt::print(" {:>9}", unit.heading);
  fmt::print("\n");
  for (const std::size_t i : group.episodes) {
    const Scored& episode = session.all[i];
    fmt::print("{:<20} {:<14} {:>6}", printable(file_name(episode.file)),
               name(episode.measures.outcome), number_or("-", "{:.1f}", episode.total()));
    for (std::size_t part = 0; part < kParts; ++part)
      fmt::print(" {:>9.4g}", kUnits[part].factor * episode.measures.parts[part]);
    fmt::print("\n");
  }
  if (!group.yardstick)
    fmt::print("no score: a simulated operator of skill 1 does not succeed in this scene either\n");
}

// One sitting of one person, in the order of their dates.
struct Sitting {
  std::size_t group = 0;
  std::string session, began;
  std::vector<double> totals;
  std::size_t inserted = 0;
};

std::vector<Sitting> sittings(const Scores& session) {
  std::vector<Sitting> all;
  for (const Scored& e : session.all) {
    auto found = std::find_if(all.begin(), all.end(), [&](const Sitting& s) {
      return s.group == e.group && s.session == e.session;
    });
    if (found == all.end()) found = all.insert(all.end(), {e.group, e.session, e.date, {}, 0});
    found->totals.push_back(e.total());
    found->inserted += e.measures.outcome == Outcome::inserted;
  }
  std::stable_sort(all.begin(), all.end(), [](const Sitting& a, const Sitting& b) {
    return std::pair(a.group, a.began) < std::pair(b.group, b.began);
  });
  return all;
}

double median_score(const Sitting& sitting) {
  return std::isfinite(sitting.totals[0]) ? quantile(sitting.totals, 0.5) : NAN;
}

void print_sittings(const Scores& session) {
  const std::vector<Sitting> all = sittings(session);
  if (all.size() < 2) return;
  fmt::print("{:<40} {:<20} {:>8} {:>8} {:>7} {:>6}\n", "who", "session", "episodes", "inserted",
             "median", "best");
  for (const Sitting& s : all) {
    const double best = *std::max_element(s.totals.begin(), s.totals.end());
    fmt::print("{:<40} {:<20} {:>8} {:>8} {:>7} {:>6}\n",
               printable(session.groups[s.group].operator_, 40),
               s.session.empty() ? "-" : printable(s.session, 20), s.totals.size(), s.inserted,
               number_or("-", "{:.1f}", median_score(s)), number_or("-", "{:.1f}", best));
  }
}

void print(const Scores& session) {
  for (const Group& group : session.groups) print_group(session, group);
  print_sittings(session);
}

int score_verb(const ScoreArguments& a) {
  Provenance provenance;
  const Scores session = scored(a, provenance);
  if (!a.plot.empty()) {
    if (!session.scored)
      throw BadInput(
          fmt::format("{}: there is no score to draw: a simulated operator does not "
                      "succeed in this scene",
                      fmt::join(a.places, " ")));
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
                {"yardstick", g.yardstick ? yardstick_json(*g.yardstick) : Json(nullptr)},
                {"episodes", g.episodes.size()}};
  });
  print_result(a.output,
               {{"folders", a.places},
                {"groups", groups},
                {"sittings", json_list(sittings(session),
                                       [&](const Sitting& s) {
                                         return Json{
                                             {"operator", session.groups[s.group].operator_},
                                             {"group", s.group + 1},
                                             {"session", s.session},
                                             {"began", s.began},
                                             {"episodes", s.totals.size()},
                                             {"inserted", s.inserted},
                                             {"median_score", number_or_null(median_score(s))}};
                                       })},
                {"episodes", json_list(session.all, [](const Scored& e) { return to_json(e); })}},
               "episodes", provenance);
  return interrupted() ? kInterrupted : kDone;
}

}  // namespace

void add_score(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("score", "How good each recorded insertion was");
  auto a = std::make_shared<ScoreArguments>();
  verb->add_option(
          "folders", a->places,
          "Folder with the episodes; several, of one scene, compare persons session by session")
      ->required()
      ->type_name("DIR...");
  add_plot(*verb, a->plot, "Draw score and parts over the episodes");
  verb->add_flag("--one-operator", a->one_operator,
                 "Treat all episodes as one person's: one learning curve");
  add_output(*verb, a->output);
  add_examples(*verb,
               {"score episodes", "score episodes --plot learning.svg --csv", "score ada ben"});
  verb->callback([a, &run] { run.verb = [a] { return score_verb(*a); }; });
}

}  // namespace ferrule
