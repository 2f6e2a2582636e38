#include "app/device_arguments.hpp"

#include <fmt/format.h>

#include "app/validators.hpp"
#include "insertion/hand_device.hpp"
#include "insertion/rendering.hpp"

namespace ferrule {

CLI::Option* add_device(CLI::App& verb, DeviceArguments& a, const std::string& help) {
  auto* device =
      verb.add_option("--device", a.device, help)->type_name("auto|PATH|" + fake_names("|"));
  verb.add_option("--profile", a.profile,
                  "Profile of a device with force: a file, or the name of a shipped one "
                  "(haptic/README.md); pen unless given")
      ->needs(device)
      ->type_name("NAME|FILE");
  verb.add_flag(
          "--coupled", a.coupled,
          "Hold the fibre through a virtual coupling: contacts feel softer, and every scene is "
          "stable")
      ->needs(device);
  verb.add_option("--gain", a.gain,
                  "Factor on how far or fast the device moves the hand (haptic/README.md)")
      ->capture_default_str()
      ->needs(device)
      ->check(number_between(0.01, 100));
  return device;
}

CLI::Option* add_trainee(CLI::App& verb, std::string& trainee) {
  return verb.add_option("--trainee,--person", trainee,
                         "Name of the person who inserts; the episodes store it, and score keeps "
                         "persons apart");
}

CLI::Option* add_go_on(CLI::App& verb, bool& goes_on) {
  return verb.add_flag("--go-on-after-goal", goes_on,
                       "Continue after the success depth, until the person stops");
}

std::string person_at(const std::string& trainee, const std::string& device) {
  return (trainee.empty() ? "" : trainee + ", ") + device;
}

HandSettings hand_settings(const DeviceArguments& a, const OpenDevice& device, const Scene& scene) {
  HandSettings settings;
  settings.gain = a.gain;
  const ForceDriver* const force = device.driver->force;
  if (!force) {
    if (a.coupled) throw BadInput("--coupled: needs a device with force");
    if (!a.profile.empty()) throw BadInput("--profile: needs a device with force");
    return settings;
  }
  settings.profile = at_gain(load_device_profile(a.profile.empty() ? "pen" : a.profile), a.gain);
  if (!device.fake && a.profile.empty())
    fmt::print(stderr, "note: no --profile: the device is assumed to be a {}\n",
               settings.profile.name);
  const double step = force->step(device.transport->info(), device_range(scene, a.gain).reach);
  settings.profile.resolution = std::max(settings.profile.resolution, step);
  const std::string gain = a.gain == 1 ? "" : fmt::format(" with --gain {:g}", a.gain);
  const Coupling coupling = stable_coupling(settings.profile);
  const bool couples = coupling.stiffness > 0;
  if (a.coupled) {
    if (!couples)
      throw BadInput("--coupled: no coupling is stable on " + settings.profile.name +
                     ": it needs damping and friction");
    settings.coupling = coupling;
    return settings;
  }
  const Rendering r = rendering(scene, settings.profile);
  if (r.stable()) return settings;
  const std::string set = r.set();
  std::string ways;
  if (!set.empty()) ways += ". Stable when magnified less, up to " + set;
  if (couples)
    ways += fmt::format(". Or contacts of at most {:.4g} N/m: --coupled", coupling.stiffness);
  throw BadInput(
      fmt::format("{} on {}{}: refused for force feedback: felt stiffness {:.4g} N/m: {}{}",
                  scene.name, settings.profile.name, gain, r.stiffness, r.reasons.front(), ways));
}

}  // namespace ferrule
