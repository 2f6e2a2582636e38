#include "haptic/device_profile.hpp"

#include "sim/json_fields.hpp"
#include "sim/shipped_files.hpp"

namespace ferrule {
namespace {

constexpr ShippedFiles kProfiles = {"devices", "device profile", "one"};

}  // namespace

DeviceProfile load_device_profile(const std::string& name_or_file) {
  const std::string file = kProfiles.find(name_or_file);
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

}  // namespace ferrule
