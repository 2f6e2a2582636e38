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
  // The scene states not this number, but others of which it follows.
  bool implied = false;
  // A deviation that it shares with others: they count as one thing that chance decides.
  std::string shared{};

  const std::string& name() const noexcept { return shared.empty() ? key : shared; }

  // In that trial, in the unit of the key; redrawn as seed_of has it.
  double draw(std::uint64_t seed, std::uint64_t trial,
              std::string_view redrawn = "") const noexcept;
};

// What chance came to.
struct DecidedNumber {
  std::string key;
  double value;  // in the unit of the key
};

// Those that stand in a scene's document. Throws RefusedKey.
std::vector<DrawnNumber> drawn_numbers(const Json& document, const std::string& file);

// The document with each of them at its centre.
Json at_centre(Json document, const std::vector<DrawnNumber>& drawn);

// The document with these numbers. It says in "drawn_from" what they replace ("was"), and which
// keys are new ("added").
Json decided_document(Json document, const std::vector<DecidedNumber>& numbers);

// That of what has this name: another one, which nobody can ask for, where it is drawn again.
inline std::uint64_t seed_of(std::string_view name, std::string_view redrawn,
                             std::uint64_t seed) noexcept {
  return name == redrawn ? ~seed : seed;
}

// The document that a drawn one was drawn from; of any other one, `document` itself.
Json undrawn(Json document);

}  // namespace ferrule
