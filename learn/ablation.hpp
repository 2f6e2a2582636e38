// Ablations: a controller without one of the things that it has, to see what it needs it for.
//
//   force      it feels nothing: it observes a wrench of 0
//   memory     it does not know how far it has moved: it observes a displacement of 0; a network
//              sees one moment, without a past or a state
//   tilt       it does not tilt: its rates of tilt are 0
//   variation  it learned where nothing varies: all demonstrations with the same parts, from the
//              middle of where they start
//
// A law and a search run without, as they are. A network is trained again, on demonstrations
// without: it may find another way.
#pragma once

#include <array>

#include "learn/learner.hpp"

namespace ferrule {

enum class Ablation { force, memory, tilt, variation };
inline constexpr std::array<const char*, 4> kAblations = {"force", "memory", "tilt", "variation"};
inline const char* name(Ablation what) noexcept {
  return kAblations[static_cast<std::size_t>(what)];
}

// Whether there is anything to take from it as it runs.
bool has(const ControllerFile& controller, Ablation what);

// What `make` makes, running without.
MakeController without(Ablation what, const MakeController& make);

// Demonstrations without: recorded again under `seed` without variation, else observed and tilted
// otherwise. Throws BadInput where they cannot be recorded again, and what `go_on` throws.
DemonstrationSet without(Ablation what, const DemonstrationSet& set, std::uint64_t seed,
                         const std::function<void()>& go_on = {});

// The learner's variant that trains a network without. Empty: the learner does not train one.
std::optional<Learner::Variant> without(Ablation what, const Learner& learner,
                                        const Learner::Variant& variant);

}  // namespace ferrule
