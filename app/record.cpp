// ferrule record: demonstrations from a simulated operator, a device, or a controller in the place
// of the hand.
#include <fmt/format.h>

#include <cstring>
#include <deque>
#include <exception>
#include <filesystem>
#include <utility>

#include "app/damage.hpp"
#include "app/device_arguments.hpp"
#include "app/given_controller.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/recording.hpp"
#include "app/scene_arguments.hpp"
#include "app/shards.hpp"
#include "app/trained.hpp"
#include "app/trial_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "controller/campaign_table.hpp"
#include "controller/searching_operator.hpp"
#include "controller/supervisor.hpp"
#include "controller/trial.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/base/content_hash.hpp"

namespace ferrule {
namespace {

struct RecordArguments {
  SceneArguments scene;
  DeviceArguments device;
  std::string operator_ = "simulated", out;
  OperatorSkill skill = 0.8;
  int episodes = 20;
  std::uint64_t seed = 1;
  bool append = false, supervise = false, with_device = false;
  bool other_scaling = false;
  Output output;
  const SharedJob* job = nullptr;
};

Json episode_json(const Recorded& r) {
  Json json = {{"file", r.file.empty() ? Json(nullptr) : Json(r.file)},
               {"outcome", name(r.end.outcome)},
               {"time_s", r.end.summary.task_time()},
               {"recorded_s", r.end.summary.time},
               {"peak_force_uN", 1e6 * r.end.summary.peak_force},
               {"depth_um", 1e6 * r.end.summary.depth},
               {"steps", r.end.summary.steps},
               {"unfinished_steps", r.end.summary.unfinished},
               {"why", r.end.why}};
  if (r.rating) json["rating"] = r.rating;
  if (r.timing) json["loop"] = loop_json(*r.timing, r.period);
  return json;
}

constexpr double kMuchMissed = 0.01;  // of the deadlines

// Of episode_json.
void tell(const Json& row) {
  const std::string why = row["why"];
  fmt::print("{}  {:<12} {:6.2f} s  peak {:6.3f} uN  depth {:6.2f} um{}{}\n",
             row["file"].is_null() ? "discarded" : printable(row["file"].get<std::string>()),
             row["outcome"].get<std::string>(), row["time_s"].get<double>(),
             row["peak_force_uN"].get<double>(), row["depth_um"].get<double>(),
             why.empty() ? "" : "  ", why);
  if (const std::int64_t unfinished = row["unfinished_steps"]; unfinished > 0)
    fmt::print("  {} of {} steps ended without a minimum: they lag behind until later ones\n",
               unfinished, row["steps"].get<std::int64_t>());
}

void tell_timing(const Recorded& r) {
  const PeriodStatistics& p = r.timing->periods;
  fmt::print(
      "  loop of {:g} us: p50 {:.0f}, p99 {:.0f}, p99.9 {:.0f}, worst {:.0f} us; {} of {} "
      "deadlines missed\n",
      1e6 * r.period, 1e6 * p.p50, 1e6 * p.p99, 1e6 * p.p99_9, 1e6 * p.worst, p.missed,
      p.missed + p.periods);
  if (missed_share(p) > kMuchMissed)
    fmt::print(
        stderr,
        "note: {:.1f} % of the deadlines were missed: the hand was slower than its rows say\n",
        100 * missed_share(p));
}

// What the loop of a device was not permitted.
void tell_refused(const LoopTiming& timing) {
  const auto refused = [](const char* what, int error) {
    if (error)
      fmt::print(stderr, "note: {}: {}; \"ferrule doctor\" says what permits it\n", what,
                 std::strerror(error));
  };
  refused("the loop runs without SCHED_FIFO", timing.scheduling_error);
  refused("the loop's memory is not locked", timing.locking_error);
}

// Who holds the fibre: a device, a simulated operator or a controller.
struct Holding {
  std::string name;
  std::optional<OpenDevice> device;
  HandSettings settings;  // of the device
  MakeController make;    // empty without a controller
  std::string began = date_now();
};

Holding holding(const RecordArguments& a, const Scene& scene,
                const std::optional<GivenController>& controller) {
  Holding h;
  const bool simulated = !a.with_device && a.operator_ == "simulated";
  if (a.with_device) {
    h.device = open_device("--device", a.device.device);
    h.settings = hand_settings(a.device, *h.device, scene);
    h.name = person_at(a.device.trainee, operator_name(*h.device));
  }
  if (!controller && a.supervise) throw BadInput("--supervise: needs a controller as --operator");
  if (simulated) h.name = SimulatedOperator{a.skill}.name();
  if (h.device || simulated) return h;
  if (controller) {
    if (controller->file)
      refuse_other_scaling(trained_on(*controller->file).scaling, a.operator_, scene,
                           a.other_scaling);
    h.make = controller->in(scene);
    h.name = "controller " + a.operator_;
    if (a.supervise) h.make = supervised(h.make, supervisor_limits(scene));
    if (a.supervise) h.name += ", supervised";
  } else {
    h.make = searching_operator(scene, a.skill, a.seed);
    h.name = SimulatedOperator{a.skill, true}.name();
  }
  return h;
}

// What was recorded so far.
struct Recordings {
  Json list = Json::array();
  std::size_t kept = 0;  // not discarded
  std::size_t inserted = 0, timeouts = 0, infeasible = 0;
  bool lost = false;           // the device
  std::exception_ptr trouble;  // with the device, after the first episode
};

// One episode. Empty: the operator ended the recording instead. Throws DeviceTrouble, FileTrouble.
std::optional<Recorded> record_episode(const RecordArguments& a, const Holding& holding,
                                       const TrialSetup& trial, EpisodeClaim claim,
                                       std::optional<Keys>& keys) {
  EpisodePlace place{holding.name, std::move(claim)};
  if (holding.device) place.sitting = {a.device.trainee, holding.began, a.device.goes_on};
  if (holding.device)
    return record_by_hand(*holding.device, holding.settings, trial, std::move(place), *keys);
  if (!holding.make) {
    const auto hand = simulated_operator(trial, a.skill);
    return record_one(trial, *hand, std::move(place));
  }
  const std::unique_ptr<Controller> controller = holding.make(trial.trial);
  ControllerHand hand = recorded_hand(trial, *controller);
  place.phase = [&] { return controller->phase_name(); };
  return record_one(trial, hand, std::move(place));
}

// A row of episode_json.
void take_down(const RecordArguments& a, const Json& row, Recordings& all) {
  const bool kept = !row["file"].is_null();
  all.kept += kept;
  all.inserted += kept && row["outcome"] == name(Outcome::inserted);
  all.timeouts += kept && row["outcome"] == name(Outcome::timeout);
  all.list.push_back(row);
  if (a.output.text()) tell(row);
}

void take_down(const RecordArguments& a, const Recorded& r, Recordings& all) {
  all.lost = r.end.lost;
  if (r.timing && all.list.empty()) tell_refused(*r.timing);
  take_down(a, episode_json(r), all);
  if (r.timing && a.output.text()) tell_timing(r);
  std::fflush(stdout);
}

// `head` is printed before the first episode, once there is a place for it and parts that fit.
Recordings record_all(const RecordArguments& a, const Scene& toleranced, const Holding& holding,
                      int first, const std::string& head) {
  Recordings all;
  std::optional<Keys> keys;
  if (holding.device) keys.emplace();
  std::optional<Progress> progress;  // where no keys are asked for
  if (!keys || !keys->there()) progress.emplace("recording", static_cast<std::size_t>(a.episodes));
  std::deque<Recorded> before;  // whose files are written while the next one is recorded
  const auto take = [&](std::size_t but) {
    for (; before.size() > but; before.pop_front()) {
      before.front().wait();
      take_down(a, before.front(), all);
    }
  };
  int next = first;
  for (int i = 0; i < a.episodes && !interrupted() && !all.lost;) {
    EpisodeClaim claim(a.out, next);
    const int number = claim.number();
    if (i == 0 && all.list.empty() && !claim.locked())
      fmt::print(stderr,
                 "note: {}: its file system has no locks: do not recover there while it records\n",
                 printable(a.out));
    const TrialSetup trial = feasible_setup(toleranced, a.seed, static_cast<std::uint64_t>(number));
    all.infeasible += trial.infeasible;
    if (i == 0 && all.list.empty()) {
      fmt::print("{}", head);
      std::fflush(stdout);
    }
    std::optional<Recorded> r;
    try {
      r = record_episode(a, holding, trial, std::move(claim), keys);
    } catch (const DeviceTrouble&) {
      if (all.list.empty()) throw;
      all.trouble = std::current_exception();  // what there is already is printed first
    } catch (const FileTrouble&) {
      take(0);
      throw;
    }
    if (!r) break;
    const bool last = r->last, discarded = r->discarded;
    before.push_back(std::move(*r));
    take(before.back().writing ? kWriting : 0);
    if (last) break;
    if (discarded) continue;  // the operator takes it again
    next = number + 1;
    ++i;
    if (progress) (*progress)(static_cast<std::size_t>(i));
  }
  take(0);
  return all;
}

// Of an episode that is to be recorded again, what a killed process left is removed.
EpisodeClaim claim_again(const std::string& folder, int number, const Holding& holding,
                         const TrialSetup& trial) {
  const std::string stem = folder + "/" + episode_name(number), file = stem + ".h5";
  if (auto left = EpisodeClaim::of_left(stem + ".part")) left->remove();
  if (std::filesystem::exists(file)) {
    try {
      const EpisodeInfo there = open_episode(file).info();
      if (there.operator_ != holding.name || there.seed != trial.seed ||
          there.trial != trial.trial || there.scene != trial.scene->document().dump())
        throw BadInput(file + ": is no episode of this job; move it away");
    } catch (const FileTrouble&) {  // it is damaged
    }
    std::filesystem::remove(file);
  }
  EpisodeClaim claim(folder, number);
  if (claim.number() != number) throw FileTrouble(stem + ": is being recorded by another process");
  return claim;
}

// What record_shared keeps of an episode. Throws Json::exception where it is something else.
Json kept_row(const KeptTrial& kept) {
  kept["infeasible"].get<std::size_t>();
  const Json& row = kept["row"];
  for (const char* text : {"file", "outcome", "why"}) row.at(text).get<std::string>();
  for (const char* number :
       {"time_s", "recorded_s", "peak_force_uN", "depth_um", "steps", "unfinished_steps"})
    row.at(number).get<double>();
  return {{"row", row}, {"infeasible", kept["infeasible"]}};
}

// Those of a shard; in a merge all of them, by what their shards kept.
Recordings record_shared(const RecordArguments& a, const Scene& toleranced, const Holding& holding,
                         TrialStore& store, const std::string& head) {
  const auto count = static_cast<std::size_t>(a.episodes);
  std::vector<Json> rows(count);  // null: not recorded, or by another shard
  store.begin(
      {{sha1(toleranced.document().dump()), count, [&](std::size_t k, const KeptTrial& kept) {
          if (rows[k].is_null()) rows[k] = kept_row(kept);
          return true;  // times differ
        }}});
  std::optional<Keys> no_keys;
  Progress progress("recording", count);
  struct Begun {
    TrialStore::Trial trial;
    std::size_t infeasible;
    bool cut_short;  // by a signal, after success too
    Recorded recorded;
  };
  std::deque<Begun> before;  // whose files are written while the next one is recorded
  const auto keep = [&](std::size_t but) {
    for (; before.size() > but; before.pop_front()) {
      auto& [trial, infeasible, cut_short, recorded] = before.front();
      recorded.wait();
      if (cut_short) continue;
      Json& row = rows[trial.trial];
      row = {{"row", episode_json(recorded)}, {"infeasible", infeasible}};
      row["row"]["file"] = std::filesystem::path(recorded.file).filename().string();
      store.put(trial, [&] { return row; });
    }
  };
  while (!interrupted()) {
    const auto next = store.next();
    if (!next) break;
    const int number = static_cast<int>(next->trial) + 1;
    const TrialSetup trial = feasible_setup(toleranced, a.seed, static_cast<std::uint64_t>(number));
    Recorded recorded =
        record_episode(a, holding, trial, claim_again(a.out, number, holding, trial), no_keys)
            .value();
    before.push_back({*next, trial.infeasible, interrupted(), std::move(recorded)});
    keep(kWriting);
    progress(next->trial + 1);
  }
  keep(0);
  store.done();
  fmt::print("{}", head);
  Recordings all;
  for (const Json& each : rows) {
    if (each.is_null()) continue;
    all.infeasible += each.at("infeasible").get<std::size_t>();
    Json row = each.at("row");
    row["file"] = a.out + "/" + row["file"].get<std::string>();
    take_down(a, row, all);
  }
  return all;
}

// Episodes of one folder are learned from together, in one hand's world.
void expect_same_scaling(const std::string& folder, const Scaling& now) {
  const std::vector<std::string> files = episode_files(folder);
  if (files.empty()) return;
  const Scaling its =
      scene_scaling(recorded_scene(open_episode(files.back()).info(), files.back()));
  if (its != now)
    throw BadInput(fmt::format(
        "{}: was recorded with another scaling (motion x{:.6g}, force x{:.6g}) than this scene's "
        "(x{:.6g}, x{:.6g}): no law could be fitted to both; choose another folder",
        files.back(), its.motion, its.force, now.motion, now.force));
}

int record_verb(const RecordArguments& a) {
  TrialStore* const shared = a.job->store.get();
  if (shared && (a.with_device || a.append))
    throw BadInput("--shard: does not go with --device or --append");
  const bool person = a.operator_ == "simulated" || a.operator_ == "searching" ||
                      (a.operator_ == kSearching && is_baseline(kSearching));
  std::optional<GivenController> controller;
  Provenance provenance;
  BroughtScene brought;
  if (!a.with_device && !person) {
    controller = given_controller(a.operator_, {}, a.seed);
    if (!controller->read.empty()) provenance.read(controller->read);
    if (controller->file) brought = brought_by(trained_on(*controller->file), a.operator_);
  }
  const ChosenScene chosen = a.scene.choose(brought);
  const Scene& toleranced = chosen.scene;
  provenance.in(chosen).seed("starts and operator", a.seed);
  const Holding who = holding(a, toleranced, controller);
  const std::string note =
      damage_note(toleranced) + (a.supervise ? supervisor_note(supervisor_limits(toleranced)) : "");
  const int first = next_episode_number(a.out);
  if (first > 1 && !a.append && !shared)
    throw BadInput(a.out +
                   ": already holds episodes; choose another folder, or add to them with "
                   "--append");
  if (first > 1) expect_same_scaling(a.out, scene_scaling(toleranced));
  if (!a.output.text()) fmt::print(stderr, "{}", note);
  const std::string head = a.output.text() ? provenance.head() + note : std::string();
  const Recordings all = shared ? record_shared(a, toleranced, who, *shared, head)
                                : record_all(a, toleranced, who, first, head);
  if (interrupted())
    provenance.partial(fmt::format("{} of {} episodes", all.list.size(), a.episodes));
  if (a.output.text()) {
    fmt::print("{} of {} episodes inserted\n", all.inserted, all.kept);
    if (const auto late = time_limit_note(all.timeouts, all.kept - all.inserted); !late.empty())
      fmt::print("{}\n", late);
    if (all.infeasible > 0)
      fmt::print("{} drawn pairs of parts interfered and were skipped\n", all.infeasible);
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output,
               {{"scene", toleranced.name},
                {"operator", who.name},
                {"damage", damage_json(toleranced)},
                {"episodes", all.list},
                {"infeasible_pairs", all.infeasible}},
               "episodes", provenance);
  if (all.trouble) std::rethrow_exception(all.trouble);
  if (all.lost)
    throw DeviceTrouble(who.device->transport->info().path +
                        ": the device was lost; the running episode was ended and kept");
  if (!interrupted()) return kDone;
  fmt::print(stderr, "stopped by {}: the running episode was ended and kept; {} of {} are there\n",
             stopped_by(), all.kept, a.episodes);
  return kInterrupted;
}

}  // namespace

void add_record(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("record", "Record demonstrations, one HDF5 file per episode");
  auto a = std::make_shared<RecordArguments>();
  a->scene.add_to(*verb, "that of the controller's training, or demo without a controller");
  add_other_scaling(*verb, a->other_scaling);
  auto* person =
      verb->add_option("--operator", a->operator_,
                       "Who holds the fibre: \"simulated\", \"searching\" for one who finds "
                       "the bore by touch, or a controller. " +
                           std::string(kControllers))
          ->capture_default_str()
          ->type_name("simulated|searching|" + std::string(kControllerType));
  auto* device = add_device(*verb, a->device,
                            "Hold the fibre with a device: the first usable one, one by its path, "
                            "or a fake one that a simulated hand moves");
  device->excludes(person);
  add_skill(*verb, a->skill, "Skill of the simulated operator")->excludes(device);
  verb->add_option("--episodes", a->episodes, "How many")
      ->capture_default_str()
      ->check(whole_number(1, 1000000));
  add_seed(*verb, a->seed, "Seed of starts and operator");
  verb->add_option("--out", a->out, "Folder for the episodes")->required()->type_name("DIR");
  verb->add_flag("--supervise", a->supervise,
                 "Put a supervisor around the controller: limits, retreat and retry");
  add_trainee(*verb, a->device.trainee)->needs(device);
  add_go_on(*verb, a->device.goes_on)->needs(device);
  verb->add_flag("--append", a->append, "Add to a folder that holds episodes already");
  add_shard(*verb, run.job);
  a->job = &run.job;
  add_output(*verb, a->output);
  add_examples(*verb, {"record --episodes 20 --seed 1 --out episodes",
                       "record --scene bench --device auto --trainee Ada --out ada"});
  verb->callback([a, device, &run] {
    a->with_device = device->count() > 0;
    run.verb = [a] { return record_verb(*a); };
  });
}

}  // namespace ferrule
