// controller.json of an insertion by touch (method "search"): the numbers of a SearchLaw, each with
// where it comes from. Written by hand, or fitted (learn/fit_search.hpp); controller/README.md and
// data/controller.schema.json state the keys.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "controller/search_law.hpp"
#include "controller/trained_on.hpp"

namespace ferrule {

struct SearchFile {
  std::vector<double> gains = std::vector<double>(kSearchGains.size());  // as kSearchGains
  std::vector<std::string> sources = std::vector<std::string>(kSearchGains.size());
  TrainedOn trained_on;  // where it was not fitted: the scenes that it is for, and their scaling
  // Of its velocities against demonstrations, where it was just fitted: the file has none [m/s].
  double residual = std::numeric_limits<double>::quiet_NaN(), held_out_residual = residual;

  MakeController maker() const { return controller_maker(SearchLaw(gains)); }
  std::size_t parameters() const { return gains.size(); }
};

// Throws FileTrouble.
void write_controller(const std::string& file, const SearchFile& controller);
// From the text of `file`. Throws BadInput.
SearchFile parse_search(const Json& json, const std::string& file);

}  // namespace ferrule
