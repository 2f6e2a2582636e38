// controller.json: a learned controller with all that is needed to run it and to know where it came
// from. Data: data/README.md describes the keys.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "controller/insertion_law.hpp"
#include "sim/json_fields.hpp"

namespace ferrule {

struct FittedGain {
  double value = 0;
  // 95 % interval; NaN where the data leave it open (the gain is at its bound).
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

struct ControllerFile {
  std::array<FittedGain, kGains> gains;
  double reaction_time = 0;  // delay of the demonstrator, identified and not imitated [s]
  // Provenance.
  std::vector<std::string> scenes;    // names of the scenes it was learned in
  std::vector<std::string> episodes;  // files it was fitted to
  std::vector<std::string> held_out;
  double residual = 0, held_out_residual = 0;  // root mean square of the velocity error [m/s]
  std::size_t rows = 0;
  std::uint64_t seed = 0;

  InsertionLaw law() const;
};

// Throws FileTrouble.
void write_controller(const std::string& file, const ControllerFile& controller);
// Throws FileTrouble, BadInput.
ControllerFile read_controller(const std::string& file);

}  // namespace ferrule
