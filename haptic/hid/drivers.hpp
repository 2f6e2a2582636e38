// The table of drivers, and what is asked of it.
#pragma once

#include <span>
#include <string>

#include "haptic/hid/driver.hpp"

namespace ferrule {

// Where two recognise a device, the first one drives it.
std::span<const Driver> drivers();

// The driver of a device; null: none, or one that is never to be driven.
const Driver* driver_of(const HidInfo& info);

// What a device is that is never to be driven; null: any other.
const char* never_driven(const HidInfo& info) noexcept;

// What such a device lacks, so that its driver cannot use it; empty: nothing.
std::string missing(const HidInfo& info, const Driver& driver);

// The driver whose model has that name, "fake:..."; null: none.
const Driver* fake_driver(const std::string& name) noexcept;
// The names of all models.
std::string fake_names(const std::string& separator);

}  // namespace ferrule
