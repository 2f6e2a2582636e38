// Devices set to a scene's task, and a fake of them that anyone can try.
#pragma once

#include <memory>

#include "haptic/hid/driver.hpp"
#include "sim/model/state.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

// With `gain` 1: the scene's speed limit, 1 mrad/s (assumed), half the hand's range; `gain` > 0
// multiplies these.
DeviceRange device_range(const Scene& scene, double gain) noexcept;

// The settings of a device whose hand holds the fibre of `start`. `full_force` [N]: what a device
// with force does at most.
DriverSettings driver_settings(const Scene& scene, const State& start, double gain,
                               double full_force) noexcept;

// SIMULATED: a model of a device with its real driver, and a scripted hand that sees the fibre. It
// aligns the fibre with the bore, as far as its axes go, pushes it a tenth (2 um at least) deeper
// than the scene's success depth, and presses a button. It feels nothing and errs never: for trying
// the program, not for learning from. Its time is that of `read`.
std::unique_ptr<Device> fake_hand(const Driver& driver, std::unique_ptr<FakeTransport> model,
                                  const Scene& scene, const State& start, double gain,
                                  double full_force);

}  // namespace ferrule
