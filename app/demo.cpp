// ferrule demo: the main job on built-in defaults. Record, fit, evaluate, one report.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "app/damage.hpp"
#include "app/demo_report.hpp"
#include "app/given_controller.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/recording.hpp"
#include "app/scene_arguments.hpp"
#include "app/trial_arguments.hpp"
#include "app/verbs.hpp"
#include "controller/controller_file.hpp"
#include "insertion/simulated_operator.hpp"
#include "learn/fit_law.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

constexpr double kSkills[] = {0.5, 0.9};
constexpr int kEpisodesPerSkill = 10;
constexpr std::size_t kTrials = 500;
constexpr const char* kMarker = ".ferrule-demo";

struct DemoArguments {
  SceneArguments scene;
  std::string out = "ferrule-demo";
  std::uint64_t seed = 1;
  int threads = 0;
  bool json = false;
};

// Makes the folder, or empties one that an earlier demo made. What no demo made is not touched.
void make_folder(const std::string& folder) {
  const fs::path marker = fs::path(folder) / kMarker;
  std::error_code error;
  if (fs::exists(folder, error) && !fs::is_empty(folder, error)) {
    if (error || !fs::exists(marker, error))
      throw BadInput(folder + ": exists and was not made by a demo; choose another with --out");
    for (const char* name : {"controller.json", "report.html"})
      fs::remove(fs::path(folder) / name, error);
    for (int number = 1; number <= kEpisodesPerSkill * static_cast<int>(std::size(kSkills));
         ++number)
      for (const char* ending : {".h5", ".part"})
        fs::remove(fs::path(folder) / "episodes" / (episode_name(number) + ending), error);
  }
  fs::create_directories(folder, error);
  if (error) throw FileTrouble(folder + ": cannot be made: " + error.message());
  write_text(marker.string(),
             "made by ferrule demo, which replaces its own files here when it runs again\n");
}

class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

void tell(const std::string& text) {
  fmt::print(stderr, "{}\n", text);
}

std::string episodes_folder(const DemoArguments& a) {
  return a.out + "/episodes";
}

// Episode `number`, by a simulated trainee.
Recorded record(const DemoArguments& a, const Scene& scene, double skill, int number) {
  const std::string folder = episodes_folder(a);
  EpisodeClaim claim(folder, number);
  if (claim.number() != number)
    throw BadInput(folder + ": holds other episodes; choose another folder with --out");
  const TrialSetup trial = feasible_setup(scene, a.seed, static_cast<std::uint64_t>(number));
  const auto device = simulated_operator(trial, skill);
  return record_one(trial, *device, {SimulatedOperator{skill}.name(), std::move(claim)});
}

// Waits until the files of all but the last `but` are whole.
void wait(DemoReport& report, std::size_t but) {
  for (std::size_t i = 0; i + but < report.recorded.size(); ++i) report.recorded[i].recorded.wait();
}

// False where Ctrl-C ended it.
bool record_all(const DemoArguments& a, DemoReport& report) {
  tell(fmt::format("1/4 recording {} episodes each of simulated trainees of skill {} and {}",
                   kEpisodesPerSkill, kSkills[0], kSkills[1]));
  const Stopwatch clock;
  Progress progress("recording", std::size(kSkills) * kEpisodesPerSkill);
  int number = 0;
  for (const double skill : kSkills)
    for (int i = 0; i < kEpisodesPerSkill; ++i) {
      report.recorded.push_back({skill, record(a, *report.scene, skill, ++number)});
      wait(report, kWriting);
      if (interrupted()) {
        wait(report, 0);
        tell(fmt::format("stopped by {}; episodes so far are in {}", stopped_by(),
                         printable(episodes_folder(a))));
        return false;
      }
      progress(static_cast<std::size_t>(number));
    }
  wait(report, 0);
  report.record_seconds = clock.seconds();
  return true;
}

void fit(const DemoArguments& a, DemoReport& report) {
  tell("2/4 fitting the insertion law");
  const Stopwatch clock;
  report.fit = fit_law(load_demonstrations(episodes_folder(a)), a.seed);
  write_controller(a.out + "/controller.json", report.fit.controller);
  report.fit_seconds = clock.seconds();
}

void evaluate(const DemoArguments& a, DemoReport& report) {
  tell(fmt::format("3/4 evaluating it and the constant-velocity baseline in {} trials each",
                   kTrials));
  const Stopwatch clock;
  const Scene& scene = *report.scene;
  const auto campaign = [&](const MakeController& make, const char* what) {
    return run_campaign(scene, make, report.trial_seed(), kTrials, a.threads,
                        Progress(what, kTrials), interrupted);
  };
  report.learned = campaign(controller_maker(report.fit.controller.law()), "learned");
  report.baseline = campaign(baseline(kStraight, scene, report.trial_seed()), "baseline");
  report.evaluate_seconds = clock.seconds();
}

// The demonstration to show: of the most skilled that inserted, the one that started lowest. Like
// the paper's, it touches the lower side of the bore.
std::string shown(const DemoReport& report) {
  std::string file;
  double lowest = INFINITY;
  for (std::size_t i = 0; i < report.recorded.size(); ++i) {
    const auto& [skill, recorded] = report.recorded[i];
    const double y = draw_start(*report.scene, report.seed, i + 1).tip[1];
    if (recorded.end.outcome != Outcome::inserted || skill < kSkills[1] || y > lowest) continue;
    lowest = y;
    file = recorded.file;
  }
  return file;
}

int demo_verb(const DemoArguments& a) {
  const ChosenScene chosen = a.scene.choose();
  const Scene& scene = chosen.scene;
  fmt::print(stderr, "{}", damage_note(scene));
  make_folder(a.out);
  const Stopwatch clock;
  DemoReport report;
  report.scene = &scene;
  report.scene_arguments = SceneArguments{a.scene.name(), a.scene.settings}.given().substr(1);
  report.seed = a.seed;

  report.provenance.in(chosen).seed("demonstrations", a.seed).seed("trials", report.trial_seed());
  if (!record_all(a, report)) return kInterrupted;
  fit(a, report);
  if (interrupted()) throw Stopped{"episodes and controller are in " + a.out};
  evaluate(a, report);
  if (interrupted()) throw Stopped{"episodes and controller are in " + a.out};
  tell("4/4 writing the report");
  const std::string file = a.out + "/report.html";
  report.shown = shown(report);
  write_report(file, report);
  if (a.json)
    print_json(report_json(report), report.provenance);
  else
    fmt::print("{}{}{}", report.provenance.head(), report_text(report), report.provenance.foot());
  tell(fmt::format("{:.0f} s in all; open {}", clock.seconds(),
                   printable(fs::absolute(file).string())));
  return kDone;
}

}  // namespace

void add_demo(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("demo", "Record, fit and evaluate on built-in defaults, with a report");
  auto a = std::make_shared<DemoArguments>();
  a->scene.add_to(*verb);
  verb->add_option("--out", a->out, "Folder for episodes, controller and report")
      ->capture_default_str()
      ->type_name("DIR");
  add_seed(*verb, a->seed, "Seed of everything");
  add_threads(*verb, a->threads);
  add_json(*verb, a->json);
  add_examples(*verb, {"demo", "demo --scene bench --seed 2 --out bench-demo"});
  verb->callback([a, &run] { run.verb = [a] { return demo_verb(*a); }; });
}

}  // namespace ferrule
