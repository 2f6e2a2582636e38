// What all controller files share: the format, and what the controller was trained on, the object
// "trained_on".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sim/scene/json_fields.hpp"

namespace ferrule {

inline constexpr const char* kControllerFormat = "ferrule controller";

struct TrainedEpisode {
  std::string file, sha1;  // and the hash of its bytes
  bool operator==(const TrainedEpisode&) const = default;
};

struct TrainedOn {
  std::vector<std::string> scenes;  // names of the scenes of the episodes
  std::vector<TrainedEpisode> episodes;
  std::vector<TrainedEpisode> held_out;  // to measure the error on
  std::size_t rows = 0;                  // of the episodes, that were fitted to
  std::uint64_t seed = 0;                // of the choice of what is held out, and of the fit
};

Json to_json(const TrainedOn& trained_on);
// From the object "trained_on" of `fields`, whose document is `file`. Throws BadInput.
TrainedOn read_trained_on(JsonFields& fields, const std::string& file);

}  // namespace ferrule
