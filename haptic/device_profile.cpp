#include "haptic/device_profile.hpp"

#include <algorithm>
#include <filesystem>

#include "sim/json_fields.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

std::string profile_folder() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    const fs::path installed = program.parent_path().parent_path() / "share/ferrule/devices";
    if (fs::is_directory(installed)) return installed.string();
  }
  return FERRULE_DEVICES;
}

std::string profile_file(const std::string& name_or_file) {
  const bool bare = name_or_file.find('/') == std::string::npos &&
                    name_or_file.find(".json") == std::string::npos;
  if (!bare || fs::is_regular_file(name_or_file)) return name_or_file;
  const std::string shipped = profile_folder() + "/" + name_or_file + ".json";
  if (fs::exists(shipped)) return shipped;
  std::string message = name_or_file + ": no such device profile, and no shipped one of that name:";
  for (const auto& name : shipped_device_profiles()) message += " " + name;
  throw FileTrouble(message);
}

}  // namespace

DeviceProfile load_device_profile(const std::string& name_or_file) {
  const std::string file = profile_file(name_or_file);
  const Json document = parse_json(read_text(file), file);
  JsonFields f(document, file);
  if (f.present("$schema")) f.text("$schema");
  DeviceProfile profile;
  profile.name = f.text("name");
  profile.source = f.text("source");
  profile.mass = f.number("mass_kg", rule::positive());
  profile.damping = f.number("damping_N_s_m", rule::not_negative());
  profile.coulomb = f.number("coulomb_N", rule::not_negative());
  profile.resolution = 1e-6 * f.number("resolution_um", rule::not_negative());
  profile.max_force = f.number("max_force_N", rule::positive());
  profile.max_stiffness = f.number("max_stiffness_N_m", rule::positive());
  profile.period = 1 / f.number("rate_Hz", rule::between(10, 1e5, "must be between 10 and 100000"));
  profile.delay_periods = static_cast<int>(f.integer("delay_periods", 0, 100));
  f.finish();
  return profile;
}

std::vector<std::string> shipped_device_profiles() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(profile_folder(), error)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".json" && path.stem().extension() != ".schema")
      names.push_back(path.stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace ferrule
