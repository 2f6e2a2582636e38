// ferrule doctor: can this scene be felt on this device, on this machine?
#include <fmt/format.h>

#include <cstring>

#include "app/connected.hpp"
#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/scene_arguments.hpp"
#include "app/validators.hpp"
#include "app/verbs.hpp"
#include "capture/loop_timing.hpp"
#include "insertion/rendering.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

struct DoctorArguments {
  SceneArguments scene;
  std::string device = "pen";
  double gain = 1, seconds = 1;
  bool json = false;
};

std::string mend_scheduling(int error) {
  if (error == 0) return "";
  return "echo \"$USER - rtprio 80\" | sudo tee /etc/security/limits.d/80-ferrule.conf, and log in "
         "again (in a container: run it with --cap-add SYS_NICE --ulimit rtprio=80)";
}

std::string mend_locking(int error) {
  if (error == 0) return "";
  return "echo \"$USER - memlock unlimited\" | sudo tee -a /etc/security/limits.d/80-ferrule.conf, "
         "and log in again (in a container: run it with --ulimit memlock=-1)";
}

// What is looked at, and found.
struct Findings {
  double gain;
  Scene scene;
  DeviceProfile device;  // with that gain
  Rendering felt;
  LoopTiming loop;
  std::vector<FoundDevice> connected;

  double felt_at_limit() const { return scene_scaling(scene).force * scene.limits.force; }
};

Json loop_and_mends(const Findings& f) {
  Json timed = loop_json(f.loop, f.device.period);
  timed["sched_fifo_mend"] = mend_scheduling(f.loop.scheduling_error);
  timed["memory_locked_mend"] = mend_locking(f.loop.locking_error);
  return timed;
}

Json to_json(const Findings& f) {
  const DeviceProfile& device = f.device;
  const StiffnessRange& tip = f.felt.tip;
  const double K = f.felt.stiffness, B = f.felt.damping;
  const Coupling coupling = stable_coupling(device);
  return {
      {"scene", f.scene.name},
      {"device", device.name},
      {"device_source", device.source},
      {"gain", f.gain},
      {"tip",
       {{"states", tip.states},
        {"touching", tip.touching},
        {"two_point", tip.two_point},
        {"stiffness_N_m", tip.largest},
        {"smallest_stiffness_N_m", tip.smallest},
        {"damping_N_s_m", tip.damping}}},
      {"felt",
       {{"stiffness_N_m", K},
        {"smallest_stiffness_N_m", f.felt.magnified * tip.smallest},
        {"damping_N_s_m", B},
        {"force_at_limit_N", f.felt_at_limit()},
        {"device_max_force_N", device.max_force}}},
      {"bounds",
       {{"damping_needed_N_s_m", damping_needed(device, K, B)},
        {"device_damping_N_s_m", device.damping},
        {"passive_stiffness_N_m", passive_stiffness(device, B)},
        {"quantised_stiffness_N_m", number_or_null(resting_stiffness(device))},
        {"device_max_stiffness_N_m", device.max_stiffness},
        {"stable_stiffness_N_m", stable_stiffness(device, B)}}},
      {"stable", f.felt.stable()},
      {"reasons", f.felt.reasons},
      {"largest_hand_force_N", number_or_null(f.felt.largest_hand_force)},
      {"set", f.felt.set()},
      {"coupling", {{"stiffness_N_m", coupling.stiffness}, {"damping_N_s_m", coupling.damping}}},
      {"loop", loop_and_mends(f)},
      {"devices", json_list(f.connected, device_json)}};
}

void line(const std::string& what, const std::string& value) {
  fmt::print("{:<34} {}\n", what, value);
}

void print_rendering(const Findings& f) {
  const DeviceProfile& device = f.device;
  const StiffnessRange& tip = f.felt.tip;
  const double K = f.felt.stiffness, B = f.felt.damping, felt_limit = f.felt_at_limit();
  const Coupling coupling = stable_coupling(device);
  fmt::print("scene {} on device {}{}: {}\n\n", f.scene.name, device.name,
             f.gain == 1 ? "" : fmt::format(" with --gain {:g}", f.gain), device.source);
  line("states looked at",
       fmt::format("{}: {} touch, {} with end and side", tip.states, tip.touching, tip.two_point));
  line("stiffness of the fibre's end",
       fmt::format("{:.4g} to {:.4g} N/m", tip.smallest, tip.largest));
  line("felt stiffness K", fmt::format("{:.4g} N/m, magnified {:.4g} times", K, f.felt.magnified));
  line("felt damping B", fmt::format("{:.3g} N s/m", B));
  line("felt force at limits.force_uN",
       fmt::format("{:.3g} N; the device gives {:.3g} N{}", felt_limit, device.max_force,
                   felt_limit > device.max_force ? ", the rest is cut off" : ""));
  line("damping needed, K T (2d+1)/2 + |B|",
       fmt::format("{:.4g} N s/m; the device has {:.4g}", damping_needed(device, K, B),
                   device.damping));
  line("K allowed by damping", fmt::format("{:.4g} N/m", passive_stiffness(device, B)));
  line("K allowed by resolution, 2 f_c/D", fmt::format("{:.4g} N/m", resting_stiffness(device)));
  line("K allowed by the maker", fmt::format("{:.4g} N/m", device.max_stiffness));
  const std::string set = f.felt.set();
  line("largest stable force scaling",
       !set.empty() ? set : "none: nothing is felt, or nothing is stable");
  line("virtual coupling",
       fmt::format("{:.4g} N/m, {:.3g} N s/m", coupling.stiffness, coupling.damping));
}

void print_loop(const LoopTiming& loop, double period) {
  const PeriodStatistics& timing = loop.periods;
  line("loop of this machine", fmt::format("{} periods of {:g} us, {} deadlines missed",
                                           timing.periods, 1e6 * period, timing.missed));
  line("period p50, p99, p99.9, worst",
       fmt::format("{:.0f}, {:.0f}, {:.0f}, {:.0f} us", 1e6 * timing.p50, 1e6 * timing.p99,
                   1e6 * timing.p99_9, 1e6 * timing.worst));
  const auto granted = [](const char* what, int error, const std::string& mend) {
    line(what, error == 0 ? "granted" : fmt::format("{}; mend: {}", std::strerror(error), mend));
  };
  granted("SCHED_FIFO", loop.scheduling_error, mend_scheduling(loop.scheduling_error));
  granted("memory locked", loop.locking_error, mend_locking(loop.locking_error));
}

void print_connected(const std::vector<FoundDevice>& connected) {
  if (connected.empty()) line("devices", "none is connected");
  for (const FoundDevice& d : connected) {
    const Json json = device_json(d);
    line(d.info.path,
         fmt::format("{} {}{}", json["id"].get<std::string>(), json["state"].get<std::string>(),
                     d.forbidden()        ? "; mend: " + udev_command(d.info)
                     : !d.missing.empty() ? ": " + d.missing
                                          : ""));
  }
}

void print_verdict(const Rendering& felt) {
  if (felt.stable()) {
    fmt::print("STABLE: the device renders {:.4g} N/m.\n", felt.stiffness);
    return;
  }
  fmt::print("REFUSED for force feedback: {:.4g} N/m is more than the device renders:\n",
             felt.stiffness);
  for (const std::string& reason : felt.reasons) fmt::print("  {}\n", reason);
}

int doctor(const DoctorArguments& a) {
  if (a.device == "auto" || a.device.starts_with("fake:") || a.device.starts_with("/dev/hidraw"))
    throw BadInput("--device " + a.device +
                   ": must be a profile, \"pen\" or a file; devices that are connected are listed "
                   "with any");
  const ChosenScene chosen = a.scene.choose();
  Provenance provenance;
  provenance.in(chosen);
  Findings f{a.gain, chosen.scene, at_gain(load_device_profile(a.device), a.gain), {}, {}, {}};
  {
    Progress progress("looking at states", 1);
    f.felt = rendering(f.scene, f.device, [&](std::size_t done, std::size_t all) {
      progress(done, "", all);
      return !interrupted();
    });
  }
  end_if_interrupted();
  f.loop = time_loop(f.scene, f.felt.tip.stiffest, f.device.period, a.seconds, interrupted);
  end_if_interrupted();
  f.connected = find_devices();
  if (a.json) {
    print_json(to_json(f), provenance);
  } else {
    fmt::print("{}", provenance.head());
    print_rendering(f);
    fmt::print("\n");
    print_loop(f.loop, f.device.period);
    print_connected(f.connected);
    fmt::print("\n");
    print_verdict(f.felt);
    fmt::print("{}", provenance.foot());
  }
  return f.felt.stable() ? kDone : kFailed;
}

}  // namespace

void add_doctor(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "doctor", "Can a scene be felt on a device: stability, loop rate, permissions");
  auto a = std::make_shared<DoctorArguments>();
  a->scene.add_to(*verb);
  verb->add_option("--device", a->device, "Device profile: a file, or the name of a shipped one")
      ->capture_default_str()
      ->type_name("NAME|FILE");
  verb->add_option("--gain", a->gain,
                   "Factor on how far the device moves the hand, as in record (haptic/README.md)")
      ->capture_default_str()
      ->check(number_between(0.01, 100));
  verb->add_option("--seconds", a->seconds, "How long the loop is measured")
      ->capture_default_str()
      ->check(number_between(0.01, 3600));
  add_json(*verb, a->json);
  add_examples(*verb,
               {"doctor --scene demo --device pen", "doctor --scene bench --gain 0.5 --json"});
  verb->callback([a, &run] { run.verb = [a] { return doctor(*a); }; });
}

}  // namespace ferrule
