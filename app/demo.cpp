// ferrule demo: the main job on built-in defaults. Record, fit, evaluate, one report.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>

#include "app/recording.hpp"
#include "app/report.hpp"
#include "app/verb.hpp"
#include "controller/controller_file.hpp"
#include "insertion/scene_scaling.hpp"
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

struct Arguments {
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
  if (fs::exists(folder) && !fs::is_empty(folder, error)) {
    if (error || !fs::exists(marker))
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

class Clock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  }

 private:
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

int demo_verb(const Arguments& a) {
  const Scene scene = a.scene.load();
  const Scaling scaling = scene_scaling(scene);
  make_folder(a.out);
  watch_for_interrupt();
  const auto tell = [&](const std::string& text) { fmt::print(stderr, "{}\n", text); };
  const Clock clock;

  tell(fmt::format("1/4 recording {} episodes each of simulated trainees of skill {} and {}",
                   kEpisodesPerSkill, kSkills[0], kSkills[1]));
  Report report;
  report.scene = &scene;
  report.scene_arguments = "--scene " + a.scene.scene;
  for (const std::string& setting : a.scene.settings)
    report.scene_arguments += " --set '" + setting + "'";
  report.seed = a.seed;
  const std::string episodes = a.out + "/episodes";
  {
    Progress progress("recording", std::size(kSkills) * kEpisodesPerSkill);
    int number = 0;
    for (const double skill : kSkills)
      for (int i = 0; i < kEpisodesPerSkill; ++i) {
        ++number;
        if (claim_episode(episodes, number) != number)
          throw BadInput(episodes + ": holds other episodes; choose another folder with --out");
        const auto [drawn, trial, infeasible] =
            feasible_trial(scene, a.seed, static_cast<std::uint64_t>(number));
        const State start = draw_start(*drawn, a.seed, trial);
        const auto device = simulated_operator(*drawn, start, skill, 1e-3, a.seed, trial);
        report.recorded.push_back({skill, record_one(*drawn, start, *device,
                                                     {fmt::format("simulated, skill {}", skill),
                                                      episodes, number, a.seed, trial})});
        if (interrupted()) {
          tell("stopped by Ctrl-C; episodes so far are in " + episodes);
          return kInterrupted;
        }
        progress(static_cast<std::size_t>(number));
      }
  }
  report.record_seconds = clock.seconds();
  stop_watching_for_interrupt();

  tell("2/4 fitting the insertion law");
  const Clock fit_clock;
  const DemonstrationSet set = load_demonstrations(episodes);
  report.fit = fit_law(set, a.seed);
  const std::string controller = a.out + "/controller.json";
  write_controller(controller, report.fit.controller);
  report.fit_seconds = fit_clock.seconds();

  tell(fmt::format("3/4 evaluating it and the constant-velocity baseline in {} trials each",
                   kTrials));
  const Clock evaluate_clock;
  const MakeController law = controller_maker(report.fit.controller.law());
  const MakeController constant =
      controller_maker(ConstantVelocity(scaling.motion * scene.limits.speed));
  // Seeded apart from the demonstrations, so that no trial starts where one did.
  const std::uint64_t seed = a.seed + 1'000'003;
  report.learned =
      run_campaign(scene, scaling, law, seed, kTrials, a.threads, Progress("learned", kTrials));
  report.baseline = run_campaign(scene, scaling, constant, seed, kTrials, a.threads,
                                 Progress("baseline", kTrials));
  report.evaluate_seconds = evaluate_clock.seconds();

  tell("4/4 writing the report");
  const std::string file = a.out + "/report.html";
  // The demonstration shown is, of the most skilled, the one that started lowest: like the paper's,
  // it touches the lower side of the bore.
  double lowest = INFINITY;
  for (std::size_t i = 0; i < report.recorded.size(); ++i) {
    const auto& [skill, recorded] = report.recorded[i];
    const double y = draw_start(scene, a.seed, i + 1).tip[1];
    if (recorded.end.outcome != Outcome::inserted || skill < kSkills[1] || y > lowest) continue;
    lowest = y;
    report.shown = recorded.file;
  }
  write_report(file, report);
  if (a.json)
    print_json(report_json(report));
  else
    fmt::print("{}", report_text(report));
  tell(fmt::format("{:.0f} s in all; open {}", clock.seconds(), fs::absolute(file).string()));
  return kDone;
}

}  // namespace

void add_demo(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("demo", "Record, fit and evaluate on built-in defaults, with a report");
  auto a = std::make_shared<Arguments>();
  a->scene.add_to(*verb, "demo");
  verb->add_option("--out", a->out, "Folder for episodes, controller and report")
      ->capture_default_str()
      ->type_name("DIR");
  add_seed(*verb, a->seed, "Seed of everything");
  verb->add_option("--threads", a->threads, "0: all cores; the result does not depend on it")
      ->capture_default_str()
      ->check(CLI::Range(0, 4096));
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] { run = [a] { return demo_verb(*a); }; });
}

}  // namespace ferrule
