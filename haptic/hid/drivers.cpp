#include "haptic/hid/drivers.hpp"

#include "haptic/hid/force_stick.hpp"
#include "haptic/hid/space_mouse.hpp"

namespace ferrule {
namespace {

bool recognises(const Driver& driver, const HidInfo& info) {
  try {
    return driver.recognises(info);
  } catch (const DeviceTrouble&) {
    return false;
  }
}

}  // namespace

std::span<const Driver> drivers() {
  static const Driver table[] = {kSpaceMouseDriver, kForceStickDriver};
  return table;
}

const Driver* driver_of(const HidInfo& info) {
  if (never_driven(info)) return nullptr;
  for (const Driver& driver : drivers())
    if (recognises(driver, info)) return &driver;
  return nullptr;
}

const char* never_driven(const HidInfo& info) noexcept {
  for (const Driver& driver : drivers())
    if (const char* what = driver.never(info)) return what;
  return nullptr;
}

std::string missing(const HidInfo& info, const Driver& driver) {
  try {
    driver.check(info);
  } catch (const DeviceTrouble& trouble) {
    const std::string why = trouble.what(), path = info.path + ": ";
    return why.starts_with(path) ? why.substr(path.size()) : why;
  }
  return {};
}

const Driver* fake_driver(const std::string& name) noexcept {
  for (const Driver& driver : drivers())
    if (name == driver.fake_name) return &driver;
  return nullptr;
}

std::string fake_names(const std::string& separator) {
  std::string names;
  for (const Driver& driver : drivers())
    names += (names.empty() ? "" : separator) + driver.fake_name;
  return names;
}

}  // namespace ferrule
