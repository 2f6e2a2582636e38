// What changes while a fibre is inserted.
#pragma once

#include <array>
#include <tuple>
#include <type_traits>

#include "sim/geometry/contact_depth.hpp"
#include "sim/model/breakdown.hpp"

namespace ferrule {

static_assert(std::tuple_size_v<TermForces> == kContactPlaces);

struct ContactState {
  bool closed = false;
  double depth = 0;                   // penetration of mean surfaces [m], where closed
  Vector3d stuck = Vector3d::Zero();  // where the contact's material point is stuck [m]
  int branch = 0;                     // of the adhesion's curve (sim/laws/maugis.hpp)
};

struct State {
  Pose tip = Pose::Zero();      // pose of the inserted end [m, rad]
  Pose command = Pose::Zero();  // pose of the holder at `time` [m, rad]
  double time = 0;              // [s]
  EdgeSide side = EdgeSide::throat;
  bool bridge = false;  // a liquid bridge spans the gap
  // Of a gas shut in ahead of the end, p V - p_0 V [J] (sim/laws/flow.hpp).
  double air = 0;
  std::array<ContactState, kContactPlaces> contact;
  // Of the step before, for inertia and second order; dt_before is 0 where there was none.
  Pose velocity = Pose::Zero();         // of the end [m/s, rad/s]
  Pose tip_before = Pose::Zero();       // [m, rad]
  Pose velocity_before = Pose::Zero();  // [m/s, rad/s]
  double dt_before = 0;                 // [s]

  // Inserted length l_f [m], >= 0.
  double inserted_length() const noexcept { return tip[0] < 0 ? -tip[0] : 0.0; }
};

// A state as a row of numbers: for files and for comparing bit for bit. Some of its numbers:
struct StateField {
  const char* prefix;  // of their names
  const char* names;   // one each
  const char* units;   // one each
  const char* about;   // how a file describes them
};

constexpr auto contact_numbers(auto& contact) {
  return std::tie(contact.closed, contact.depth, contact.stuck, contact.branch);
}

// Calls visit(field, numbers_of) for each field, in the order of the row. numbers_of(state) is a
// tuple of references to the numbers, and to vectors of them.
template <class Visit>
constexpr void for_each_field(const Visit& visit) {
  const char* const pose = "x y z tilt_y tilt_z";
  const char* const lengths = "m m m rad rad";
  const char* const rates = "m/s m/s m/s rad/s rad/s";
  const char* const contact = "closed depth stuck_x stuck_y stuck_z branch";
  const char* const of_contact = "1 m m m m 1";
  using Field = StateField;
  visit(Field{"tip_", pose, lengths, "tip: x y z tilt_y tilt_z"},
        [](auto& s) { return std::tie(s.tip); });
  visit(Field{"hand_", pose, lengths, "hand at the tip's scale: x y z tilt_y tilt_z"},
        [](auto& s) { return std::tie(s.command); });
  visit(Field{"", "time", "s", "time"}, [](auto& s) { return std::tie(s.time); });
  visit(Field{"", "on_face", "1", "on_face"}, [](auto& s) { return std::tie(s.side); });
  visit(Field{"", "bridge", "1", "bridge"}, [](auto& s) { return std::tie(s.bridge); });
  visit(Field{"end_", contact, of_contact,
              "end contact: closed depth stuck_x stuck_y stuck_z branch"},
        [](auto& s) { return contact_numbers(s.contact[kEnd]); });
  visit(Field{"side_", contact, of_contact, "side contact: the same"},
        [](auto& s) { return contact_numbers(s.contact[kSide]); });
  visit(Field{"velocity_", pose, rates, "velocity (5)"},
        [](auto& s) { return std::tie(s.velocity); });
  visit(Field{"tip_before_", pose, lengths, "tip before (5)"},
        [](auto& s) { return std::tie(s.tip_before); });
  visit(Field{"velocity_before_", pose, rates, "velocity before (5)"},
        [](auto& s) { return std::tie(s.velocity_before); });
  visit(Field{"", "period_before", "s", "period before"},
        [](auto& s) { return std::tie(s.dt_before); });
  visit(Field{"", "air", "J", "air"}, [](auto& s) { return std::tie(s.air); });
}

inline constexpr int kStateSize = [] {
  int size = 0;
  for_each_field([&](const StateField& field, auto) {
    ++size;
    for (const char* c = field.names; *c; ++c) size += *c == ' ';
  });
  return size;
}();
using StateRow = Eigen::Matrix<double, kStateSize, 1>;

inline StateRow to_row(const State& state) noexcept {
  StateRow row;
  double* at = row.data();
  const auto put = [&](const auto& part) {
    if constexpr (requires { part.rows(); })
      for (const double x : part) *at++ = x;
    else
      *at++ = static_cast<double>(part);
  };
  for_each_field([&](const StateField&, auto numbers_of) {
    std::apply([&](const auto&... parts) { (put(parts), ...); }, numbers_of(state));
  });
  return row;
}

// The state of such a row.
inline State state_of(const StateRow& row) noexcept {
  State state;
  const double* at = row.data();
  const auto take = [&]<class Part>(Part& part) {
    if constexpr (requires { part.rows(); })
      for (double& x : part) x = *at++;
    else if constexpr (std::is_same_v<Part, double> || std::is_same_v<Part, int>)
      part = static_cast<Part>(*at++);
    else  // one of two
      part = static_cast<Part>(*at++ != 0);
  };
  for_each_field([&](const StateField&, auto numbers_of) {
    std::apply([&](auto&... parts) { (take(parts), ...); }, numbers_of(state));
  });
  return state;
}

}  // namespace ferrule
