// What a sensor at the holder must be able to do: success against noise and bias, and without one.
//
// In each shipped scene the insertion law is fitted to 20 demonstrations of a simulated operator of
// skill 0.8 with the sensor as shipped, and inserts by itself with each of a list of sensors whose
// errors are parts of the scene's force limit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct SensorRow {
  std::string scene, sensor;     // "none": straight in at constant velocity
  std::size_t trials, inserted;  // pairs of parts that fit; of those
};

// `seed`: of demonstrations, fit and trials. `trials`: of each sensor.
std::vector<SensorRow> bench_sensors(std::uint64_t seed, std::size_t trials,
                                     const std::vector<std::string>& scenes,
                                     const GoOn& go_on = {});

}  // namespace ferrule
