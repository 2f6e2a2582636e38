// Numbers of a scene that chance decides in each trial, each by itself: its generator is keyed by
// (seed, trial, key), so that no other one changes it.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/scene/distribution.hpp"

namespace ferrule {

struct DrawnNumber {
  std::string key;  // dotted
  Distribution distribution;
};

// Those that stand in a scene's document. Throws RefusedKey.
std::vector<DrawnNumber> drawn_numbers(const Json& document, const std::string& file);

// The document with each of them at its centre.
Json at_centre(Json document, const std::vector<DrawnNumber>& drawn);

// The document with the numbers of that trial, that of `redrawn` with those of another seed
// (seed_of). It says in "drawn_from" what they replace ("was"), and which keys are new ("added").
Json drawn_document(Json document, const std::vector<DrawnNumber>& drawn, std::uint64_t seed,
                    std::uint64_t trial, const std::string& redrawn = "");

// That of what `key` names: another one, which nobody can ask for, where it is drawn again.
inline std::uint64_t seed_of(std::string_view key, std::string_view redrawn,
                             std::uint64_t seed) noexcept {
  return key == redrawn ? ~seed : seed;
}

// States a number that the document does not have yet.
void add_drawn(Json& document, const std::string& key, double value);

// The document that a drawn one was drawn from; of any other one, `document` itself.
Json undrawn(Json document);

}  // namespace ferrule
