// ferrule score: how good each insertion of a folder was, for trainers of operators.
#include "capture/score.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "app/plot.hpp"
#include "app/verb.hpp"

namespace ferrule {
namespace {

struct ScoreArguments {
  std::string folder, plot;
  bool json = false;
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
  std::string file, operator_;
  Measures measures;
};

Plot learning_curve(const std::vector<Scored>& all, const std::vector<Score>& scores) {
  Axes total{"", "score", false, false, {}}, parts{"episode", "100 best / own", false, false, {}};
  Series inserted{"inserted", {}, {}, Series::points_on_line};
  Series others{"not inserted", {}, {}, Series::points_on_line};
  std::vector<double> number;
  for (std::size_t i = 0; i < all.size(); ++i) {
    number.push_back(static_cast<double>(i) + 1);
    Series& series = all[i].measures.outcome == Outcome::inserted ? inserted : others;
    series.x.push_back(number.back());
    series.y.push_back(scores[i].total);
  }
  others.style = Series::points;
  total.series = {inserted, others};
  for (std::size_t part = 0; part < kParts; ++part) {
    Series series{kPartNames[part], number, {}, Series::points_on_line};
    for (const Score& s : scores) series.y.push_back(100 * s.parts[part]);
    parts.series.push_back(series);
  }
  return {"Score over the episodes", {total, parts}, 860, 320};
}

Json to_json(const Scored& episode, const Score& score) {
  const Measures& m = episode.measures;
  Json json = {{"file", episode.file},
               {"operator", episode.operator_},
               {"outcome", name(m.outcome)},
               {"completion", m.completion},
               {"score", number_or_null(score.total)}};
  for (std::size_t part = 0; part < kParts; ++part) {
    json[kUnits[part].key] = kUnits[part].factor * m.parts[part];
    json["parts"][kPartNames[part]] = number_or_null(score.parts[part]);
  }
  return json;
}

void print_table(const std::vector<Scored>& all, const std::vector<Score>& scores) {
  fmt::print("{:<20} {:<14} {:>6}", "episode", "outcome", "score");
  for (const Unit& unit : kUnits) fmt::print(" {:>9}", unit.heading);
  fmt::print("\n");
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Measures& m = all[i].measures;
    fmt::print("{:<20} {:<14} {:>6}", std::filesystem::path(all[i].file).filename().string(),
               name(m.outcome), number_or("-", "{:.1f}", scores[i].total));
    for (std::size_t part = 0; part < kParts; ++part)
      fmt::print(" {:>9.4g}", kUnits[part].factor * m.parts[part]);
    fmt::print("\n");
  }
  if (!std::isfinite(scores[0].total))
    fmt::print("no episode succeeded: there is no best to score against\n");
}

int score_verb(const ScoreArguments& a) {
  std::vector<Scored> all;
  std::vector<Measures> measures;
  for (const std::string& file : episode_files(a.folder)) {
    const Episode episode = read_episode(file);
    measures.push_back(measure(episode, recorded_scene(episode, file)));
    all.push_back({file, episode.info.operator_, measures.back()});
  }
  if (all.empty()) throw BadInput(a.folder + ": no episodes in it");
  const std::vector<Score> scores = score(measures);
  if (!a.plot.empty()) {
    if (!std::isfinite(scores[0].total))
      throw BadInput(a.folder + ": no episode succeeded: there is no score to draw");
    write_plot(a.plot, learning_curve(all, scores));
  }
  if (!a.json) {
    print_table(all, scores);
    return kDone;
  }
  Json list = Json::array();
  for (std::size_t i = 0; i < all.size(); ++i) list.push_back(to_json(all[i], scores[i]));
  print_json({{"folder", a.folder}, {"episodes", list}});
  return kDone;
}

}  // namespace

void add_score(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("score", "How good each recorded insertion was");
  auto a = std::make_shared<ScoreArguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes")->required()->type_name("DIR");
  verb->add_option("--plot", a->plot, "Draw score and parts over the episodes")
      ->type_name("FILE.svg");
  add_json(*verb, a->json);
  verb->callback([a, &run] { run = [a] { return score_verb(*a); }; });
}

}  // namespace ferrule
