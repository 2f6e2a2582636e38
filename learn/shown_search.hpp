// What demonstrations of who searches show of the numbers of a search by touch
// (controller/search_law.hpp), each in the phase that learn/fit_search.hpp says.
#pragma once

#include <cmath>
#include <string_view>
#include <vector>

#include "controller/search_file.hpp"
#include "learn/demonstrations.hpp"

namespace ferrule {

// The places of some in kSearchGains.
namespace search_gain {
constexpr std::size_t place(std::string_view name) {
  std::size_t i = 0;
  while (kSearchGains[i].name != name) ++i;
  return i;
}
inline constexpr std::size_t approach_speed = place("approach_speed"),
                             touch_speed = place("touch_speed"),
                             insert_speed = place("insert_speed"), tilt_rate = place("tilt_rate"),
                             touch_force = place("touch_force"), push_force = place("push_force"),
                             hold_time = place("hold_time"), lift = place("lift"),
                             tilt = place("tilt"), yield = place("yield"),
                             near_entrance = place("near_entrance"),
                             fibre_radius = place("fibre_radius");
}  // namespace search_gain

// A number that was seen.
struct ShownNumber {
  std::size_t gain;
  double value;
};

// A row of inserting, for Ceres: what its velocity is beside the law's, in parts of the speed. The
// unknowns are in units of `push`, `yield` and `speed`.
struct PushedRow {
  Eigen::Vector3d force, velocity;
  double speed, push, yield;

  template <class T>
  bool operator()(const T* push_force, const T* yielding, const T* fastest, T* error) const {
    const T most = push * push_force[0];
    error[0] =
        velocity[0] / speed + fastest[0] * fmax(T(0), 1.0 - force.squaredNorm() / (most * most));
    for (int i = 1; i < 3; ++i) error[i] = (velocity[i] - yield * yielding[0] * force[i]) / speed;
    return true;
  }
};

// What one episode shows.
struct ShownSearch {
  std::vector<ShownNumber> shown;
  std::vector<PushedRow> pushed;

  std::vector<double> of(std::size_t gain) const {
    std::vector<double> values;
    for (const ShownNumber& s : shown)
      if (s.gain == gain) values.push_back(s.value);
    return values;
  }
};

// Of each of these; forces are those of `reaction` [s] before. `search`: what it is compared with.
std::vector<ShownSearch> shown_by(const std::vector<const Demonstration*>& demonstrations,
                                  double reaction, const SearchFile& search);

// The delay between force and lateral velocity while they insert [s].
double reaction_while_inserting(const std::vector<const Demonstration*>& demonstrations);

}  // namespace ferrule
