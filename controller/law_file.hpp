// controller.json of a law (method "ceres"), with all that is needed to run it and to know where it
// came from. controller/README.md describes the keys, data/controller.schema.json states them.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "controller/law.hpp"
#include "controller/trained_on.hpp"

namespace ferrule {

struct FittedGain {
  double value = 0;
  // 95 % interval; NaN where the data leave it open (the gain is at its bound).
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
};

// Error of one law in predicting the velocities of episodes that it was not fitted to.
struct CrossValidated {
  LawKind kind;
  double error, standard_error;  // mean over the episodes, and its standard error [m/s]
};

struct LawFile {
  LawKind kind = LawKind::insertion;
  // As gain_table(kind); where the demonstrators tilted, those of kTiltGains behind them.
  std::vector<FittedGain> gains = std::vector<FittedGain>(kGains);
  double reaction_time = 0;  // delay of the demonstrator, identified and not imitated [s]
  // Provenance.
  TrainedOn trained_on;
  double residual = 0, held_out_residual = 0;    // root mean square of the velocity error [m/s]
  std::vector<CrossValidated> cross_validation;  // of the laws that were compared, if any

  Law law() const;
  MakeController maker() const { return controller_maker(law()); }
  std::size_t parameters() const { return gains.size(); }
};

// Throws FileTrouble.
void write_controller(const std::string& file, const LawFile& controller);
// Throws FileTrouble, BadInput.
LawFile read_law(const std::string& file);
// From the text of `file`. Throws BadInput.
LawFile parse_law(const Json& json, const std::string& file);

}  // namespace ferrule
