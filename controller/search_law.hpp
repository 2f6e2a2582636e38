// An insertion that finds the bore by touch, without learning: controller/search/steps.h, in C for
// the sake of `ferrule export`, as a Controller.
#pragma once

#include <array>
#include <optional>
#include <span>

#include "controller/controller.hpp"
#include "controller/gain.hpp"
#include "controller/search/steps.h"

namespace ferrule {

// What a file states (controller/search_file.hpp); controller/search/numbers.h has the constants.
inline constexpr std::array kSearchGains = std::to_array<Gain>({
    {"approach_speed", "v_a", "m/s", Gain::positive},
    {"touch_speed", "v_t", "m/s", Gain::positive},
    {"insert_speed", "v_i", "m/s", Gain::positive},
    {"tilt_rate", "w", "rad/s", Gain::positive},
    {"touch_force", "F_t", "N", Gain::positive},
    {"push_force", "F_p", "N", Gain::positive},
    {"turn_moment", "M_t", "N m", Gain::positive},
    {"hold_time", "t_h", "s", Gain::positive},
    {"lift", "l", "m", Gain::positive},
    {"tilt", "theta", "rad", Gain::positive},
    {"yield", "A", "m/(s N)", Gain::not_negative},
    {"near_entrance", "d_e", "m", Gain::not_negative},
    {"fibre_radius", "r", "m", Gain::positive},
    {"bore_radius", "R", "m", Gain::positive},
    {"mouth_radius", "R_m", "m", Gain::positive},
    {"lead_in_length", "l_m", "m", Gain::not_negative},
});
// The last ones are sizes of the parts, not choices.
inline constexpr std::size_t kSearchSizes = 4;

class SearchLaw : public Controller {
 public:
  // One number per gain of the table. Without `own` it finds out about the hand.
  explicit SearchLaw(std::span<const double> gains,
                     const std::optional<ferrule_own_hand>& own = {}) noexcept;

  HandTwist command(const Observation& observation) noexcept override;
  const char* phase_name() const noexcept override;

 private:
  ferrule_search search_;
};

}  // namespace ferrule
