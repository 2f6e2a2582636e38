// ferrule record: demonstrations from a simulated operator, a device, or a controller at the hand's
// place.
#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "app/recording.hpp"
#include "app/verb.hpp"
#include "capture/hand_device.hpp"
#include "capture/simulated_operator.hpp"
#include "controller/load_controller.hpp"
#include "controller/supervisor.hpp"
#include "controller/trial.hpp"

namespace ferrule {

FeasibleTrial feasible_trial(const Scene& scene, std::uint64_t seed, std::uint64_t trial) {
  constexpr std::size_t kMost = 10000;
  FeasibleTrial found{nullptr, trial, 0};
  while (!(found.scene = draw_scene(scene, seed, found.trial))) {
    if (++found.infeasible == kMost)
      throw BadInput(scene.name + ": tolerance: of " + std::to_string(kMost) +
                     " drawn pairs of parts not one fits");
    found.trial += std::uint64_t{1} << 32;
  }
  return found;
}

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
  if (const Mapping* mapping = device.mapping()) info.mapping = mapping_text(*mapping);
  Recorder recorder(folder, number, info);
  const EpisodeEnd end = run_episode(
      scene, start, device, ForceSensor(scene.sensor, seed, trial), info.period,
      [&](const RowVector& row, const RawCounts& counts) { recorder.add(row, counts); },
      interrupted);
  return {recorder.finish(end.outcome, end.why), end.outcome, end.summary};
}

namespace {

struct Arguments {
  SceneArguments scene;
  std::string operator_ = "simulated", device, out;
  double skill = 0.8, gain = 1;
  int episodes = 20;
  std::uint64_t seed = 1;
  bool append = false, supervise = false, json = false;
};

// A device with a person at it: each read waits for its time.
class InTime : public Device {
 public:
  InTime(std::unique_ptr<Device> device, bool& lost) : device_(std::move(device)), lost_(lost) {}
  HandSample read(double t) override {
    std::this_thread::sleep_until(begin_ + std::chrono::duration<double>(t));
    const HandSample sample = device_->read(t);
    lost_ = sample.lost;
    return sample;
  }
  void render(const HandWrench& wrench) override { device_->render(wrench); }
  const Mapping* mapping() const noexcept override { return device_->mapping(); }

 private:
  std::unique_ptr<Device> device_;
  bool& lost_;
  std::chrono::time_point<std::chrono::steady_clock, std::chrono::duration<double>> begin_ =
      std::chrono::steady_clock::now();
};

// What --device names: a real device, open, or the model of one.
struct AtDevice {
  std::string name;
  DeviceKind kind{};
  std::unique_ptr<HidTransport> transport;
  std::optional<FakeModel> fake;

  // Its driver at the start of an episode. A device that does not work takes the `journal` along
  // that was reserved for the episode.
  std::unique_ptr<Device> hold(const Scene& scene, const State& start, double gain,
                               const std::string& journal, bool& lost) const {
    if (fake) return fake_hand(*fake, scene, start, gain);
    try {
      return std::make_unique<InTime>(hand_device(kind, *transport, scene, start, gain), lost);
    } catch (const DeviceTrouble&) {
      std::filesystem::remove(journal);
      throw;
    }
  }
};

AtDevice open_device(const std::string& wanted) {
  if (const auto model = fake_model(wanted))
    return {"simulated hand, " + wanted, fake_kind(*model), nullptr, model};
  if (wanted.starts_with("fake:"))
    throw BadInput("--device " + wanted + ": must be fake:spacemouse or fake:pid");
  FoundDevice found = choose_device(wanted);
  return {fmt::format("{} {:04x}:{:04x}", name(*found.kind), found.info.vendor, found.info.product),
          *found.kind, open_hid(found.info), std::nullopt};
}

int record_verb(const Arguments& a) {
  const Scene toleranced = a.scene.load();
  std::optional<AtDevice> at;
  if (!a.device.empty()) at = open_device(a.device);
  const bool simulated = !at && a.operator_ == "simulated";
  if ((at || simulated) && a.supervise)
    throw BadInput("--supervise: needs a controller as --operator");
  MakeController make;
  if (!at && !simulated) make = load_controller(a.operator_);
  const int first = next_episode_number(a.out);
  if (first > 1 && !a.append)
    throw BadInput(a.out +
                   ": already holds episodes; choose another folder, or add to them with "
                   "--append");
  int next = first;
  const std::string name = at ? at->name
                           : simulated
                               ? fmt::format("simulated, skill {}", a.skill)
                               : "controller " + a.operator_ + (a.supervise ? ", supervised" : "");
  bool lost = false;
  const Scaling scaling = scene_scaling(toleranced);
  if (a.supervise) make = supervised(make, supervisor_limits(toleranced, scaling));

  watch_for_interrupt();
  Json list = Json::array();
  std::size_t inserted = 0, infeasible = 0;
  Progress progress("recording", static_cast<std::size_t>(a.episodes));
  for (int i = 0; i < a.episodes && !interrupted() && !lost; ++i) {
    const int number = claim_episode(a.out, next);
    next = number + 1;
    const FeasibleTrial drawn =
        feasible_trial(toleranced, a.seed, static_cast<std::uint64_t>(number));
    const Scene& scene = *drawn.scene;
    const std::uint64_t trial = drawn.trial;
    infeasible += drawn.infeasible;
    const State start = draw_start(scene, a.seed, trial);
    std::unique_ptr<Controller> controller;
    if (make) controller = make(trial);
    std::unique_ptr<Device> device;
    if (at)
      device = at->hold(scene, start, a.gain, a.out + "/" + episode_name(number) + ".part", lost);
    else if (simulated)
      device = simulated_operator(scene, start, a.skill, 1e-3, a.seed, trial);
    else
      device = std::make_unique<ControllerHand>(*controller, scaling.motion_to_hand(start.hand),
                                                scaling.motion * scene.limits.speed,
                                                1.1 * scaling.motion * scene.success.depth);
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
    print_json({{"scene", toleranced.name},
                {"operator", name},
                {"episodes", list},
                {"infeasible_pairs", infeasible}});
  else
    fmt::print("{} of {} episodes inserted\n", inserted, list.size());
  if (infeasible > 0 && !a.json)
    fmt::print("{} drawn pairs of parts interfered and were put aside\n", infeasible);
  if (lost)
    throw DeviceTrouble(at->transport->info().path +
                        ": the device was lost; the running episode was ended and kept");
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
  auto* person = verb->add_option("--operator", a->operator_,
                                  "Who holds the fibre: \"simulated\", or a controller file")
                     ->capture_default_str()
                     ->type_name("simulated|FILE");
  verb->add_option("--device", a->device,
                   "Hold the fibre yourself, with the first usable device or that of a path; or "
                   "try it with a simulated hand on a fake one")
      ->excludes(person)
      ->type_name("auto|PATH|fake:spacemouse|fake:pid");
  verb->add_option("--gain", a->gain,
                   "How far or fast the device moves the hand, of the usual (capture/README.md)")
      ->capture_default_str()
      ->check(number_between(0.01, 100));
  verb->add_option("--skill", a->skill, "Skill of the simulated operator")
      ->capture_default_str()
      ->check(number_between(0, 1));
  verb->add_option("--episodes", a->episodes, "How many")
      ->capture_default_str()
      ->check(CLI::Range(1, 1000000));
  add_seed(*verb, a->seed, "Seed of starts and operator");
  verb->add_option("--out", a->out, "Folder for the episodes")->required()->type_name("DIR");
  verb->add_flag("--supervise", a->supervise,
                 "Put a supervisor around the controller: limits, retreat and retry");
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
