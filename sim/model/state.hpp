// What changes while a fibre is inserted.
#pragma once

#include <array>

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

// A state as a row of numbers: for files and for comparing bit for bit.
inline constexpr int kStateSize = 42;
using StateRow = Eigen::Matrix<double, kStateSize, 1>;

inline StateRow to_row(const State& s) noexcept {
  StateRow row;
  row << s.tip, s.command, s.time, s.side == EdgeSide::face ? 1.0 : 0.0, s.bridge ? 1.0 : 0.0,
      StateRow::Zero().head<12>(), s.velocity, s.tip_before, s.velocity_before, s.dt_before, s.air;
  for (int place = 0; place < kContactPlaces; ++place) {
    const ContactState& c = s.contact[place];
    row.segment<6>(13 + 6 * place) << (c.closed ? 1.0 : 0.0), c.depth, c.stuck,
        static_cast<double>(c.branch);
  }
  return row;
}

// The state of such a row.
inline State state_of(const StateRow& row) noexcept {
  State s;
  s.tip = row.head<5>();
  s.command = row.segment<5>(5);
  s.time = row[10];
  s.side = row[11] != 0 ? EdgeSide::face : EdgeSide::throat;
  s.bridge = row[12] != 0;
  for (int place = 0; place < kContactPlaces; ++place) {
    const Eigen::Matrix<double, 6, 1> c = row.segment<6>(13 + 6 * place);
    s.contact[place] = {c[0] != 0, c[1], c.segment<3>(2), static_cast<int>(c[5])};
  }
  s.velocity = row.segment<5>(25);
  s.tip_before = row.segment<5>(30);
  s.velocity_before = row.segment<5>(35);
  s.dt_before = row[40];
  s.air = row[41];
  return s;
}

}  // namespace ferrule
