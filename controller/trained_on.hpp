// What all controller files share: the heading, the ranges of gains, and what the controller was
// trained on, the object "trained_on".
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "controller/gain.hpp"
#include "haptic/scaling.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {

inline constexpr const char* kControllerFormat = "ferrule controller";

// Reads "format", "format_version", "method" and "world". Throws BadInput where they are others.
void expect_heading(JsonFields& fields, const std::string& method, std::int64_t version);

// What a gain's value may be.
Rule range_of(const Gain& gain);

struct TrainedEpisode {
  std::string file, sha1;  // and the hash of its bytes
  // What its start and its operator's chance were drawn with. Files of before do not state it.
  std::optional<std::uint64_t> seed{}, trial{};
  bool operator==(const TrainedEpisode&) const = default;
};

struct TrainedOn {
  std::vector<std::string> scenes;  // names of the scenes of the episodes
  std::vector<TrainedEpisode> episodes;
  std::vector<TrainedEpisode> held_out;  // to measure the error on
  std::size_t rows = 0;                  // of the episodes, that were fitted to
  std::uint64_t seed = 0;                // of the choice of what is held out, and of the fit
  bool partial = false;                  // stopped before the fit was whole
  std::size_t rollouts = 0;  // of its own, labelled by the simulated operator, learned from too
  // Files of before do not state what follows.
  std::optional<Scaling> scaling{};  // between hand and tip, of all episodes
  double speed_limit = 0;            // of the scene at the tip, the largest [m/s]; 0: not stated
  double force_limit = 0;            // at the holder, the smallest [N]; 0: not stated
  Json scene{};                      // the document, where all episodes are of one scene; or null
};

// Whether they differ by more than the rounding of a file's digits.
bool differ(const Scaling& a, const Scaling& b) noexcept;

// Empty, or what is wrong: `scene` scales the hand otherwise than `trained`, the scaling of what
// `who` learned from. One that is not known is not held against it.
std::string scaling_trouble(const std::optional<Scaling>& trained, const std::string& who,
                            const Scene& scene);

Json to_json(const TrainedOn& trained_on);
// From the object "trained_on" of `fields`, whose document is `file`. Throws BadInput.
TrainedOn read_trained_on(JsonFields& fields, const std::string& file);

}  // namespace ferrule
