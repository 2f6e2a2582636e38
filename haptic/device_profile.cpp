#include "haptic/device_profile.hpp"

#include "sim/base/json_file.hpp"
#include "sim/base/shipped_files.hpp"

namespace ferrule {
namespace {

constexpr ShippedFiles kProfiles = {"devices", "device profile", "one"};

constexpr double kMost = 1e6;  // of any number: more is a slip of units
const Rule kPositive = {0, kMost, true, false, "must be positive and at most 1e6"};
const Rule kNotNegative = {0, kMost, false, false, "must be from 0 to 1e6"};

DeviceProfile parse_profile(const Json& document, const std::string& file) {
  JsonFields f(document, file);
  if (f.present("$schema")) f.text("$schema");
  DeviceProfile profile;
  profile.name = f.line("name", 100);
  profile.source = f.line("source", 2000);
  profile.mass = f.number("mass_kg", kPositive);
  profile.damping = f.number("damping_N_s_m", kNotNegative);
  profile.coulomb = f.number("coulomb_N", kNotNegative);
  profile.resolution = 1e-6 * f.number("resolution_um", kNotNegative);
  profile.max_force = f.number("max_force_N", kPositive);
  profile.max_stiffness = f.number("max_stiffness_N_m", kPositive);
  profile.period =
      1 / f.number("rate_Hz", rule::between(100, 1e5, "must be between 100 and 100000"));
  profile.delay_periods = static_cast<int>(f.integer("delay_periods", 0, 100));
  f.finish();
  return profile;
}

}  // namespace

DeviceProfile load_device_profile(const std::string& name_or_file) {
  const std::string file = kProfiles.find(name_or_file);
  return read_json(file, [&](const Json& document) { return parse_profile(document, file); });
}

}  // namespace ferrule
