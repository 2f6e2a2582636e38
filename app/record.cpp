// ferrule record: demonstrations from a simulated operator, or from a controller at the hand's
// place.
#include <fmt/format.h>

#include <filesystem>

#include "app/recording.hpp"
#include "app/verb.hpp"
#include "capture/simulated_operator.hpp"
#include "controller/load_controller.hpp"
#include "controller/trial.hpp"

namespace ferrule {

Recorded record_one(const Scene& scene, const State& start, Device& device,
                    const std::string& operator_name, const std::string& folder, int number,
                    std::uint64_t seed, std::uint64_t trial) {
  EpisodeInfo info;
  info.scene = scene.document.dump();
  info.operator_ = operator_name;
  info.seed = seed;
  info.trial = trial;
  info.version = program_version();
  info.build = program_build();
  Recorder recorder(folder, number, info);
  Recorded recorded{};
  recorded.outcome = run_episode(
      scene, start, device, info.period,
      [&](const RowVector& row) {
        recorder.add(row);
        recorded.summary.time = row[kTime.begin];
        recorded.summary.depth = std::max(0.0, -row[kStates.begin]);
        const Eigen::Vector3d force = row.segment<3>(kHolder.begin).transpose();
        const Eigen::Vector3d weight = row.segment<3>(kForces.begin + 6).transpose();
        recorded.summary.peak_force =
            std::max(recorded.summary.peak_force, (force - weight).norm());
      },
      interrupted);
  recorded.file = recorder.finish(recorded.outcome);
  return recorded;
}

namespace {

struct Arguments {
  SceneArguments scene;
  std::string operator_ = "simulated", out;
  double skill = 0.8;
  int episodes = 20;
  std::uint64_t seed = 1;
  bool append = false, json = false;
};

int record_verb(const Arguments& a) {
  const Scene scene = a.scene.load();
  const bool simulated = a.operator_ == "simulated";
  MakeController law;
  if (!simulated) law = load_controller(a.operator_);
  const int first = next_episode_number(a.out);
  if (first > 1 && !a.append)
    throw BadInput(a.out +
                   ": already holds episodes; choose another folder, or add to them with "
                   "--append");
  int next = first;
  const std::string name =
      simulated ? fmt::format("simulated, skill {}", a.skill) : "controller " + a.operator_;
  const Scaling scaling = scene_scaling(scene);

  watch_for_interrupt();
  Json list = Json::array();
  std::size_t inserted = 0;
  Progress progress("recording", static_cast<std::size_t>(a.episodes));
  for (int i = 0; i < a.episodes && !interrupted(); ++i) {
    const int number = claim_episode(a.out, next);
    next = number + 1;
    const auto trial = static_cast<std::uint64_t>(number);
    const State start = draw_start(scene, a.seed, trial);
    std::unique_ptr<Controller> controller;
    std::unique_ptr<Device> device;
    if (simulated) {
      device = simulated_operator(scene, start, a.skill, 1e-3, a.seed, trial);
    } else {
      controller = law(trial);
      device = std::make_unique<ControllerHand>(*controller, scaling.motion_to_hand(start.hand),
                                                scaling.motion * scene.limits.speed,
                                                1.1 * scaling.motion * scene.success.depth);
    }
    const Recorded r = record_one(scene, start, *device, name, a.out, number, a.seed, trial);
    inserted += r.outcome == Outcome::inserted;
    list.push_back({{"file", r.file},
                    {"outcome", ferrule::name(r.outcome)},
                    {"time_s", r.summary.time},
                    {"peak_force_uN", 1e6 * r.summary.peak_force},
                    {"depth_um", 1e6 * r.summary.depth}});
    if (!a.json)
      fmt::print("{}  {:<12} {:6.2f} s  peak {:6.3f} uN  depth {:6.2f} um\n", r.file,
                 ferrule::name(r.outcome), r.summary.time, 1e6 * r.summary.peak_force,
                 1e6 * r.summary.depth);
    std::fflush(stdout);
    progress(static_cast<std::size_t>(i) + 1);
  }
  if (a.json)
    print_json({{"scene", scene.name}, {"operator", name}, {"episodes", list}});
  else
    fmt::print("{} of {} episodes inserted\n", inserted, list.size());
  if (!interrupted()) return kDone;
  fmt::print(stderr,
             "stopped by Ctrl-C: the running episode was ended and kept; {} of {} are there\n",
             list.size(), a.episodes);
  return kInterrupted;
}

struct RecoverArguments {
  std::string folder;
  bool json = false;
};

int recover_verb(const RecoverArguments& a) {
  const std::vector<Recovered> all = recover(a.folder);
  Json list = Json::array();
  for (const Recovered& r : all) {
    list.push_back({{"journal", r.journal},
                    {"file", r.file.empty() ? Json(nullptr) : Json(r.file)},
                    {"rows", r.rows},
                    {"remark", r.remark}});
    if (a.json) continue;
    if (r.file.empty())
      fmt::print("{} {}\n", r.journal, r.remark);
    else
      fmt::print("{} -> {}: {} rows, outcome interrupted\n", r.journal, r.file, r.rows);
  }
  if (a.json)
    print_json({{"recovered", list}});
  else if (all.empty())
    fmt::print("{}: nothing to recover\n", a.folder);
  const bool damaged =
      std::any_of(all.begin(), all.end(), [](const Recovered& r) { return r.damaged; });
  return damaged ? kFileTrouble : kDone;
}

}  // namespace

void add_record(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("record", "Record demonstrations, one HDF5 file per episode");
  auto a = std::make_shared<Arguments>();
  a->scene.add_to(*verb, "demo");
  verb->add_option("--operator", a->operator_,
                   "Who holds the fibre: \"simulated\", or a controller file")
      ->capture_default_str()
      ->type_name("simulated|FILE");
  verb->add_option("--skill", a->skill, "Skill of the simulated operator")
      ->capture_default_str()
      ->check(number_between(0, 1));
  verb->add_option("--episodes", a->episodes, "How many")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  add_seed(*verb, a->seed, "Seed of starts and operator");
  verb->add_option("--out", a->out, "Folder for the episodes")->required()->type_name("DIR");
  verb->add_flag("--append", a->append, "Add to a folder that holds episodes already");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] { run = [a] { return record_verb(*a); }; });
}

void add_recover(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("recover", "Bring back episodes whose recording was killed");
  auto a = std::make_shared<RecoverArguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes")->required()->type_name("DIR");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  verb->callback([a, &run] { run = [a] { return recover_verb(*a); }; });
}

}  // namespace ferrule
