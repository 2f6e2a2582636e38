// What a supervisor (controller/supervisor.hpp) did in one trial.
#pragma once

#include <array>
#include <cstddef>
#include <optional>

namespace ferrule {

enum class Intervention {
  speed,         // the controller's velocity was cut to the speed limit
  acceleration,  // its change was slowed to the acceleration limit
  force,         // it was slowed because little was left to the force limit
  force_stop,    // it was stopped at once because the next period could have exceeded that
  not_finite,    // what it commanded or observed was not a finite number
  disagreement,  // it was slowed because its models disagreed
  held,          // the force held it for too long
  jam,           // it pressed on and did not advance
  retreat,       // it was taken back to try again
};
inline constexpr std::size_t kInterventions = 9;
inline constexpr std::array<const char*, kInterventions> kInterventionNames = {
    "speed",        "acceleration", "force", "force_stop", "not_finite",
    "disagreement", "held",         "jam",   "retreat"};
inline const char* name(Intervention kind) noexcept {
  return kInterventionNames[static_cast<std::size_t>(kind)];
}

struct Supervision {
  // How often each began; one that goes on for many periods counts once.
  std::array<std::size_t, kInterventions> interventions{};
  std::optional<Intervention>
      gave_up;  // why it ended the trial: not_finite, disagreement, held, jam

  std::size_t& operator[](Intervention kind) noexcept {
    return interventions[static_cast<std::size_t>(kind)];
  }
  std::size_t operator[](Intervention kind) const noexcept {
    return interventions[static_cast<std::size_t>(kind)];
  }
};

}  // namespace ferrule
