// The options of a person at a device: of `record` and `view`.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "app/recording.hpp"

namespace ferrule {

struct DeviceArguments {
  std::string device, profile, trainee;
  double gain = 1;
  bool coupled = false, goes_on = false;
};

// --device with `help`, and --profile, --coupled and --gain, which need it; returns --device.
CLI::Option* add_device(CLI::App& verb, DeviceArguments& arguments, const std::string& help);
// --trainee, which `--person` was before.
CLI::Option* add_trainee(CLI::App& verb, std::string& trainee);
// --go-on-after-goal
CLI::Option* add_go_on(CLI::App& verb, bool& goes_on);

// How a device with force renders the scene. Throws BadInput where it cannot.
HandSettings hand_settings(const DeviceArguments& arguments, const OpenDevice& device,
                           const Scene& scene);

// Whom a recording with it names: "Ada, SpaceMouse 046d:c62b", or the device alone.
std::string person_at(const std::string& trainee, const std::string& device);

}  // namespace ferrule
