// An episode that a controller was trained on, or held against.
#pragma once

#include <string>
#include <vector>

#include "sim/json_fields.hpp"

namespace ferrule {

struct TrainedEpisode {
  std::string file, sha1;  // and the hash of its bytes
  bool operator==(const TrainedEpisode&) const = default;
};

Json to_json(const std::vector<TrainedEpisode>& episodes);
// From the list at `key` of `fields`, whose document is `file`. Throws BadInput.
std::vector<TrainedEpisode> read_episodes(JsonFields& fields, const std::string& key,
                                          const std::string& file);

}  // namespace ferrule
