// What a controller observes, once per period, in the hand's world: the one description that
// running, fitting and exporting a controller go through.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>

#include "haptic/scaling.hpp"

namespace ferrule {

struct Observation {
  HandWrench wrench;  // at the holder, relative to that at rest at the start [N, N m]
  // Of the holder past where the bore's entrance is taken to be [m], >= 0.
  double depth;
  double time;  // since the start [s], >= 0
  // Of the holder since the start [m, rad]; as the depth it is what a stage's encoders have.
  HandPose displacement = HandPose::Zero();
  double height = 0;  // of the holder before that entrance [m]; < 0 past it
  // Of the trial: a larger force at the holder ends it [N], > 0; infinite where nobody says it.
  double force_limit = std::numeric_limits<double>::infinity();
};

// Of a holder that began at `start`, with the entrance taken to be at x = `entrance` [m].
inline Observation observe(const HandWrench& wrench, const HandPose& holder, const HandPose& start,
                           double entrance, double time,
                           double force_limit = std::numeric_limits<double>::infinity()) noexcept {
  const double height = holder[0] - entrance;
  return {wrench, std::max(0.0, -height), time, holder - start, height, force_limit};
}

// What a learned policy (controller/policy.hpp) takes in of a channel. With `past`: its value at
// several times; it is 0 before the start, and in training that of one reaction time before.
enum class PolicyInput { none, present, past };

struct ObservationChannel {
  const char* name;     // in controller files; of a scalar also the argument in C
  const char* unit;     // in controller files
  const char* meaning;  // in the C header, of a scalar
  double (*value)(const Observation&) noexcept;
  PolicyInput policy;
  double negligible;  // in training, a standard deviation below which it counts as constant [unit]
};

inline constexpr int kWrenchChannels = HandWrench::RowsAtCompileTime;
template <int component>
double observed_wrench(const Observation& o) noexcept {
  return o.wrench[component];
}
inline double observed_depth(const Observation& o) noexcept {
  return o.depth;
}
inline double observed_time(const Observation& o) noexcept {
  return o.time;
}
template <int component>
double observed_displacement(const Observation& o) noexcept {
  return o.displacement[component];
}
inline double observed_height(const Observation& o) noexcept {
  return o.height;
}

// The components of the wrench, then scalars, in the order of the arguments of the C header. Time
// is for laws alone: with it a policy could ignore what it feels.
inline constexpr auto kObservation = std::to_array<ObservationChannel>({
    {"force_x", "N", "along x", observed_wrench<0>, PolicyInput::past, 1e-3},
    {"force_y", "N", "along y", observed_wrench<1>, PolicyInput::past, 1e-3},
    {"force_z", "N", "along z", observed_wrench<2>, PolicyInput::past, 1e-3},
    {"moment_y", "N m", "about y", observed_wrench<3>, PolicyInput::past, 1e-3},
    {"moment_z", "N m", "about z", observed_wrench<4>, PolicyInput::past, 1e-3},
    {"depth", "m", "of the hand past the bore's entrance [m], >= 0", observed_depth,
     PolicyInput::present, 1e-6},
    {"time", "s", "since the start [s]", observed_time, PolicyInput::none, 1e-3},
});

// The hand's own motion.
inline constexpr auto kMotion = std::to_array<ObservationChannel>({
    {"displacement_x", "m", "along x", observed_displacement<0>, PolicyInput::present, 1e-6},
    {"displacement_y", "m", "along y", observed_displacement<1>, PolicyInput::present, 1e-6},
    {"displacement_z", "m", "along z", observed_displacement<2>, PolicyInput::present, 1e-6},
    {"tilt_y", "rad", "about y", observed_displacement<3>, PolicyInput::present, 1e-6},
    {"tilt_z", "rad", "about z", observed_displacement<4>, PolicyInput::present, 1e-6},
    {"height", "m", "of the hand before the bore's entrance [m], < 0 past it", observed_height,
     PolicyInput::present, 1e-6},
});

constexpr int policy_channels(PolicyInput which) noexcept {
  return static_cast<int>(
      std::count_if(kObservation.begin(), kObservation.end(),
                    [which](const ObservationChannel& c) { return c.policy == which; }));
}
inline constexpr int kPastChannels = policy_channels(PolicyInput::past);
inline constexpr int kPresentChannels = policy_channels(PolicyInput::present);
inline constexpr int kPolicyChannels = kPastChannels + kPresentChannels;

// What a policy takes in: the channels with a past, then the others, each in the order above.
inline constexpr auto kPolicyInputs = [] {
  std::array<ObservationChannel, kPolicyChannels> inputs{};
  std::size_t n = 0;
  for (const PolicyInput which : {PolicyInput::past, PolicyInput::present})
    for (const ObservationChannel& channel : kObservation)
      if (channel.policy == which) inputs[n++] = channel;
  return inputs;
}();

// What one with a memory takes in: the wrench, and its own motion.
inline constexpr int kMemoryChannels = kWrenchChannels + static_cast<int>(kMotion.size());
inline constexpr auto kMemoryInputs = [] {
  std::array<ObservationChannel, kMemoryChannels> inputs{};
  std::copy_n(kObservation.begin(), kWrenchChannels, inputs.begin());
  std::copy(kMotion.begin(), kMotion.end(), inputs.begin() + kWrenchChannels);
  return inputs;
}();

}  // namespace ferrule
