// ferrule compare: every way to insert, on the same trials.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "app/campaign_table.hpp"
#include "app/plot.hpp"
#include "app/verb.hpp"
#include "bench/contest.hpp"
#include "capture/episode.hpp"
#include "controller/supervisor.hpp"

namespace ferrule {
namespace {

struct Arguments {
  SceneArguments scene;
  std::string folder, plot;
  std::vector<std::string> transfer, learners;
  std::vector<std::size_t> demonstrations;
  std::size_t trials = 1000;
  double skill = 0.8;
  std::uint64_t seed = 7, fit_seed = 1;
  int threads = 0;
  bool supervise = false, json = false;
};

constexpr const char* kTeacher = "simulated operator";

// Success by the distance of the start from the axis: eighths of the trials.
struct Ring {
  double from, to;  // [m]
  std::size_t feasible, inserted;
};

struct Entry {
  Contestant contestant;
  double ns = 0;  // per action
  std::vector<TrialResult> results;
  CampaignSummary summary{};
  std::vector<Ring> rings{};
  std::optional<Comparison>
      against_teacher{};  // empty for the teacher, and without feasible trials
};

std::vector<Ring> by_misalignment(const std::vector<TrialResult>& results,
                                  const std::vector<Vector2d>& starts) {
  constexpr std::size_t kRings = 8;
  std::vector<std::size_t> order(starts.size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return starts[a].norm() < starts[b].norm(); });
  std::vector<Ring> rings;
  for (std::size_t i = 0; i < kRings; ++i) {
    const std::size_t begin = order.size() * i / kRings, end = order.size() * (i + 1) / kRings;
    if (begin == end) continue;
    Ring ring{starts[order[begin]].norm(), starts[order[end - 1]].norm(), 0, 0};
    for (std::size_t k = begin; k < end; ++k) {
      const Outcome outcome = results[order[k]].outcome;
      ring.feasible += outcome != Outcome::infeasible;
      ring.inserted += outcome == Outcome::inserted;
    }
    rings.push_back(ring);
  }
  return rings;
}

double share(std::size_t part, std::size_t all) {
  return all > 0 ? static_cast<double>(part) / static_cast<double>(all) : NAN;
}

Plot misalignment_plot(const std::vector<Entry>& entries) {
  Axes axes{"distance of the start from the axis [um]", "inserted [%]", false, false, {}};
  for (const Entry& e : entries) {
    Series series{e.contestant.name, {}, {}, Series::points_on_line};
    for (const Ring& ring : e.rings) {
      series.x.push_back(0.5e6 * (ring.from + ring.to));
      series.y.push_back(100 * share(ring.inserted, ring.feasible));
    }
    axes.series.push_back(series);
  }
  return {"Success against misalignment", {axes}};
}

Plot map_of(const Entry& entry, const std::vector<Vector2d>& starts) {
  Series inserted{"inserted", {}, {}, Series::points}, failed{"not", {}, {}, Series::points};
  for (std::size_t k = 0; k < starts.size(); ++k) {
    if (entry.results[k].outcome == Outcome::infeasible) continue;
    Series& series = entry.results[k].outcome == Outcome::inserted ? inserted : failed;
    series.x.push_back(1e6 * starts[k].x());
    series.y.push_back(1e6 * starts[k].y());
  }
  Axes axes{"start y [um]", "start z [um]", false, false, {inserted}};
  if (!failed.x.empty()) axes.series.push_back(failed);
  return {"Starts of the trials: " + entry.contestant.name, {axes}, 640, 640, true};
}

struct Learning {
  std::string name;
  std::size_t demonstrations;
  CampaignSummary summary;
};

Plot learning_plot(const std::vector<Learning>& learning) {
  Axes axes{"demonstrations", "inserted [%]", true, false, {}};
  for (const Learning& l : learning) {
    auto series = std::find_if(axes.series.begin(), axes.series.end(),
                               [&](const Series& s) { return s.name == l.name; });
    if (series == axes.series.end())
      series = axes.series.insert(axes.series.end(), {l.name, {}, {}, Series::points_on_line});
    series->x.push_back(static_cast<double>(l.demonstrations));
    series->y.push_back(100 * l.summary.success_rate);
  }
  return {"Success against the number of demonstrations", {axes}};
}

std::string file_name(std::string name) {
  std::replace(name.begin(), name.end(), ' ', '_');
  return name;
}

std::string success_text(const CampaignSummary& s) {
  return fmt::format("{:5.1f} ({:.1f} to {:.1f})", 100 * s.success_rate, 100 * s.wilson.low,
                     100 * s.wilson.high);
}

void print_table(const std::vector<Entry>& entries) {
  fmt::print("{:<26}{:>6}{:>8}{:>10}{:>8}{:>23}{:>9}{:>10}{:>9}\n", "", "param.", "fit [s]",
             "held out", "ns", "inserted [%], 95 %", "time [s]", "peak [uN]", "loss [dB]");
  for (const Entry& e : entries) {
    const Contestant& c = e.contestant;
    fmt::print("{:<26}{:>6}{:>8}{:>10}{:>8.0f}{:>23}{:>9.2f}{:>10.2f}{:>9.4f}\n", c.name,
               c.parameters > 0 ? std::to_string(c.parameters) : "-",
               c.parameters > 0 ? fmt::format("{:.2f}", c.fit_seconds) : "-",
               c.held_out ? fmt::format("{:.4f}", 1e3 * *c.held_out) : "-", e.ns,
               success_text(e.summary), e.summary.time.median, 1e6 * e.summary.peak_force.median,
               e.summary.loss_dB.median);
  }
  if (entries.front().summary.interventions) {
    fmt::print("\nsupervised: trials with interventions, retreats, gave up\n");
    for (const Entry& e : entries) {
      const InterventionSummary& i = *e.summary.interventions;
      fmt::print("{:<26}{:>6}{:>8}{:>6}\n", e.contestant.name, i.trials,
                 i.kinds[static_cast<std::size_t>(Intervention::retreat)].count,
                 e.summary.outcomes[static_cast<std::size_t>(Outcome::gave_up)]);
    }
  }
  fmt::print(
      "held out: velocity error on held-out demonstrations [mm/s, hand]; ns: per action;\n"
      "time and loss: medians of the inserted, peak force: median of all\n");
}

std::vector<Learner> chosen_learners(const Arguments& a) {
  const std::vector<Learner> all = learners(a.fit_seed);
  if (a.learners.empty()) return all;
  std::vector<Learner> chosen;
  for (const Learner& learner : all)
    if (std::find(a.learners.begin(), a.learners.end(), learner.key) != a.learners.end())
      chosen.push_back(learner);
  return chosen;
}

std::vector<std::string> learner_keys() {
  std::vector<std::string> keys;
  for (const Learner& learner : learners(0)) keys.push_back(learner.key);
  return keys;
}

int compare_verb(const Arguments& a) {
  const Scene scene = a.scene.load();
  const Scaling scaling = scene_scaling(scene);
  const DemonstrationSet set = load_demonstrations(a.folder);
  if (set.demonstrations.empty()) throw BadInput(a.folder + ": no successful demonstration");
  std::vector<Scene> elsewhere;
  for (const std::string& name : a.transfer) elsewhere.push_back(load_scene(name));
  for (const Scene& other : elsewhere)
    if (const Scaling s = scene_scaling(other);
        s.motion != scaling.motion || s.force != scaling.force)
      throw BadInput(other.name + ": scales the hand otherwise than " + scene.name +
                     "; what was learned there means nothing here");
  if (!a.plot.empty()) {
    std::error_code error;
    std::filesystem::create_directories(a.plot, error);
    if (error) throw FileTrouble(a.plot + ": cannot be made: " + error.message());
  }
  watch_for_interrupt();

  const auto campaign = [&](const Scene& where, const MakeController& make,
                            const std::string& what) {
    return run_campaign(where, scaling,
                        a.supervise ? supervised(make, supervisor_limits(where, scaling)) : make,
                        a.seed, a.trials, a.threads, Progress(what, a.trials));
  };
  std::vector<Contestant> contestants = unlearned(scene, set, a.skill, a.seed);
  std::vector<Learner> ways = chosen_learners(a);
  for (auto learner = ways.begin(); learner != ways.end();) {
    fmt::print(stderr, "fitting: {}\n", learner->name);
    try {
      contestants.push_back(learner->fit(set));
    } catch (const BadInput& error) {
      if (!a.learners.empty())
        throw BadInput(a.folder + ": " + learner->name + ": " + error.what());
      fmt::print(stderr, "note: left out: {}\n", error.what());
      learner = ways.erase(learner);
      continue;
    }
    contestants.back().name = learner->name;
    ++learner;
  }
  std::vector<Vector2d> starts;
  for (std::size_t k = 0; k < a.trials; ++k)
    starts.push_back(draw_start(scene, a.seed, k).tip.segment<2>(1));
  std::vector<Entry> entries;
  for (const Contestant& c : contestants) {
    if (interrupted()) return kInterrupted;
    Entry e{c, ns_per_action(c, set.demonstrations.front()), campaign(scene, c.make, c.name)};
    e.summary = summarise(e.results);
    e.rings = by_misalignment(e.results, starts);
    entries.push_back(std::move(e));
  }
  const Entry& teacher = *std::find_if(
      entries.begin(), entries.end(), [](const Entry& e) { return e.contestant.name == kTeacher; });
  for (Entry& e : entries)
    if (&e != &teacher && e.summary.feasible > 0)
      e.against_teacher = compare(e.results, teacher.results);

  Json rows = Json::array();
  for (const Entry& e : entries) {
    const Contestant& c = e.contestant;
    Json row = {{"controller", c.name},
                {"parameters", c.parameters},
                {"fit_s", c.fit_seconds},
                {"held_out_mm_s", c.held_out ? Json(1e3 * *c.held_out) : Json(nullptr)},
                {"ns_per_action", e.ns}};
    row.update(to_json(e.summary));
    if (e.against_teacher) {
      row["against_operator"] = Json::object();
      add_json(*e.against_teacher, row["against_operator"]);
    }
    Json misalignment = Json::array();
    for (const Ring& ring : e.rings)
      misalignment.push_back({{"from_um", 1e6 * ring.from},
                              {"to_um", 1e6 * ring.to},
                              {"feasible", ring.feasible},
                              {"inserted", ring.inserted}});
    row["misalignment"] = misalignment;
    rows.push_back(row);
  }
  if (!a.json) {
    fmt::print("scene {}, {} demonstrations, {} trials each, the same for all\n\n", scene.name,
               set.demonstrations.size(), a.trials);
    print_table(entries);
    if (teacher.summary.feasible > 0)
      fmt::print("\nagainst the {} on the same trials, percentage points (95 %), McNemar p\n",
                 kTeacher);
    for (const Entry& e : entries) {
      if (!e.against_teacher) continue;
      const Comparison& d = *e.against_teacher;
      fmt::print("{:<26}{:>+7.1f} ({:+.1f} to {:+.1f})  p = {:.2g}\n", e.contestant.name,
                 100 * d.difference, 100 * d.interval.low, 100 * d.interval.high, d.mcnemar_p);
    }
  }

  // Fewer demonstrations.
  std::vector<Learning> learning;
  for (const std::size_t count : a.demonstrations) {
    if (count > set.demonstrations.size()) {
      fmt::print(stderr, "note: {} demonstrations asked for, {} are there\n", count,
                 set.demonstrations.size());
      continue;
    }
    for (const Learner& learner : ways) {
      if (interrupted()) return kInterrupted;
      const Contestant c = learner.fit(first_of(set, count));
      learning.push_back(
          {learner.name, count,
           summarise(campaign(scene, c.make, fmt::format("{}, {}", learner.name, count)))});
    }
  }
  Json by_count = Json::array();
  if (!learning.empty() && !a.json) fmt::print("\nfrom fewer demonstrations, inserted [%]\n");
  for (const Learning& l : learning) {
    Json row = {{"controller", l.name}, {"demonstrations", l.demonstrations}};
    row.update(to_json(l.summary));
    by_count.push_back(row);
    if (!a.json) fmt::print("{:<26}{:>5}  {}\n", l.name, l.demonstrations, success_text(l.summary));
  }

  // Other scenes, without fitting again.
  Json transfer = Json::array();
  for (const Scene& other : elsewhere) {
    if (!a.json) fmt::print("\nin {}, fitted in {}, inserted [%]\n", other.name, scene.name);
    const std::vector<Contestant> there = unlearned(other, set, a.skill, a.seed);
    for (std::size_t i = 0; i < contestants.size(); ++i) {
      if (interrupted()) return kInterrupted;
      const Contestant& c = i < there.size() ? there[i] : contestants[i];
      const CampaignSummary s = summarise(campaign(other, c.make, other.name + ", " + c.name));
      Json row = {{"scene", other.name}, {"controller", c.name}};
      row.update(to_json(s));
      transfer.push_back(row);
      if (!a.json)
        fmt::print("{:<26}{}  {:.2f} s  {:.2f} uN{}\n", c.name, success_text(s), s.time.median,
                   1e6 * s.peak_force.median,
                   s.feasible < s.trials ? fmt::format("  ({} infeasible)", s.trials - s.feasible)
                                         : std::string());
    }
  }

  if (!a.plot.empty()) {
    write_svg(a.plot + "/misalignment.svg", misalignment_plot(entries));
    for (const Entry& e : entries)
      write_svg(a.plot + "/map_" + file_name(e.contestant.name) + ".svg", map_of(e, starts));
    if (!learning.empty()) write_svg(a.plot + "/demonstrations.svg", learning_plot(learning));
    if (!a.json) fmt::print("\nplots are in {}\n", a.plot);
  }
  if (a.json)
    print_json({{"scene", scene.name},
                {"demonstrations", set.demonstrations.size()},
                {"trials", a.trials},
                {"seed", a.seed},
                {"rows", rows},
                {"by_demonstrations", by_count},
                {"transfer", transfer}});
  return kDone;
}

}  // namespace

void add_compare(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("compare", "Ways to insert on the same trials: baselines and learned");
  auto a = std::make_shared<Arguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes to learn from")
      ->required()
      ->type_name("DIR");
  a->scene.add_to(*verb, "bench");
  verb->add_option("--trials", a->trials, "How many, for each")
      ->capture_default_str()
      ->check(CLI::Range(std::size_t{1}, std::size_t{100000000}));
  verb->add_option("--demonstrations", a->demonstrations,
                   "Learn from the first N demonstrations too, for each N")
      ->delimiter(',')
      ->type_name("N,...")
      ->check(CLI::Range(std::size_t{3}, std::size_t{1000000}));
  verb->add_option("--transfer", a->transfer, "Try all in these scenes too, without fitting again")
      ->delimiter(',')
      ->type_name("SCENE,...");
  verb->add_option("--learners", a->learners, "Only these; all unless given")
      ->delimiter(',')
      ->check(CLI::IsMember(learner_keys()));
  verb->add_flag("--supervise", a->supervise, "All under the supervisor");
  verb->add_option("--skill", a->skill, "Skill of the simulated operator")
      ->capture_default_str()
      ->check(number_between(0, 1));
  add_seed(*verb, a->seed, "Seed of the trials");
  verb->add_option("--fit-seed", a->fit_seed, "Seed of the fits")->capture_default_str();
  verb->add_option("--threads", a->threads, "0: all cores; the result does not depend on it")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_option("--plot", a->plot,
                   "Folder for plots: success against misalignment and number "
                   "of demonstrations, maps of where each fails")
      ->type_name("DIR");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] { run = [a] { return compare_verb(*a); }; });
}

}  // namespace ferrule
