// Devices set to a scene's task, and a fake of them that anyone can try.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "haptic/device.hpp"
#include "haptic/hid/device_list.hpp"
#include "haptic/hid/fake_firmware.hpp"
#include "sim/scene/scene.hpp"
#include "sim/state.hpp"

namespace ferrule {

// What a device's ends stand for, in the hand's world.
struct DeviceRange {
  double speed, tilt_rate;  // of a velocity device at full deflection [m/s], [rad/s]
  double reach;             // of a position device to either side [m]
};

// With `gain` 1: the scene's speed limit, 1 mrad/s (assumed), half the hand's range; `gain` > 0
// multiplies these.
DeviceRange device_range(const Scene& scene, double gain) noexcept;

// The driver of an open device whose hand holds the fibre of `start`. `full_force` [N]: what a
// device with force does at most. `transport` must outlive it. Throws DeviceTrouble.
std::unique_ptr<Device> hand_device(DeviceKind kind, HidTransport& transport, const Scene& scene,
                                    const State& start, double gain, double full_force);

// Which firmware "fake:spacemouse" or "fake:pid" is; empty for other names.
std::optional<FakeModel> fake_model(const std::string& name) noexcept;
DeviceKind fake_kind(FakeModel model) noexcept;

// SIMULATED: such a device on modelled firmware with its real driver, and a scripted hand that sees
// the fibre. It aligns the fibre with the bore, as far as its axes go, pushes it a tenth (2 um at
// least) deeper than the scene's success depth, and presses a button. It feels nothing and errs
// never: for trying the program, not for learning from. Its time is that of `read`.
std::unique_ptr<Device> fake_hand(FakeModel model, const Scene& scene, const State& start,
                                  double gain, double full_force);

}  // namespace ferrule
