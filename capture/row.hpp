// One row of a demonstration: a tick of the loop (insertion/loop.hpp) as numbers.
//
// Row n, at time t_n:
//   the hand is at pose_hand(t_n); the simulator has stepped to it, which gives the state and the
//   forces at t_n; the hand feels them and moves on: `command` is its velocity over [t_n, t_n+1).
// So a row pairs a force with the velocity that answers it, never with the one that caused it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "insertion/loop.hpp"

namespace ferrule {

// A block of columns: where it is in an episode file and in a row of numbers.
struct Block {
  const char* name;
  int begin, width;
  const char* unit;     // of each, or of all
  const char* columns;  // their names and, after a semicolon, what they are

  constexpr int end() const noexcept { return begin + width; }
};

inline constexpr int kPose = 5;
inline constexpr Block kTime{"time", 0, 1, "s", "t"};
inline constexpr Block kHandPose{"hand_pose", kTime.end(), kPose, "m m m rad rad",
                                 "x y z tilt_y tilt_z"};
inline constexpr Block kHandVelocity{"hand_velocity", kHandPose.end(), kPose,
                                     "m/s m/s m/s rad/s rad/s",
                                     "x y z tilt_y tilt_z; over [t_n-1, t_n)"};
inline constexpr Block kCommand{"command", kHandVelocity.end(), kPose, "m/s m/s m/s rad/s rad/s",
                                "x y z tilt_y tilt_z; of the hand over [t_n, t_n+1)"};
inline constexpr Block kHolder{"holder_wrench", kCommand.end(), kPose, "N N N N.m N.m",
                               "Fx Fy Fz My Mz; at the tip's scale, of the fibre on the hand"};
// Those of each term.
inline constexpr Block kForces{"forces", kHolder.end(), 3 * static_cast<int>(kTerms), "N", "x y z"};
inline constexpr Block kStatus{"status", kForces.end(), 1, "1",
                               "0 ok, 1 not converged, 2 bad command, 3 capped"};
// The fields of a state (sim/model/state.hpp) name them.
inline constexpr Block kStates{"states", kStatus.end(), kStateSize, "m, rad, s", ""};
inline constexpr int kRowSize = kStates.end();
inline constexpr std::array kBlocks = {kTime,   kHandPose, kHandVelocity, kCommand,
                                       kHolder, kForces,   kStatus,       kStates};

using RowVector = Eigen::Matrix<double, 1, kRowSize>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, kRowSize, Eigen::RowMajor>;

// Where a term's force begins in a row.
constexpr int force_column(Term term) noexcept {
  return kForces.begin + 3 * static_cast<int>(term);
}
// Where a number of the state is in a row, by its name: "tip_x", "end_closed".
consteval int state_column(std::string_view name) {
  int column = kStates.begin, found = -1;
  for_each_field([&](const StateField& field, auto) {
    const std::string_view prefix = field.prefix, names = field.names;
    for (std::size_t begin = 0; begin < names.size(); ++column) {
      const std::size_t end = std::min(names.find(' ', begin), names.size());
      if (name.starts_with(prefix) &&
          name.substr(prefix.size()) == names.substr(begin, end - begin))
        found = column;
      begin = end + 1;
    }
  });
  return found < 0 ? throw "a state has no such number" : found;
}

// Of a block, of which older files have fewer columns (capture/episode_layout.hpp): their names, one
// each; what they are, in one text; the unit of each, or of all, in one text.
std::vector<std::string> column_names(const Block& block);
std::string about(const Block& block);
std::string units(const Block& block);

RowVector make_row(const Tick& tick) noexcept;

// The step that a row was made of, as far as a row tells: forces without their points of action,
// those of both points as the first's.
struct RecordedStep {
  StepResult result;
  Breakdown forces;
};
RecordedStep step_of(const RowVector& row) noexcept;

inline auto block(const RowVector& row, const Block& b) {
  return row.segment(b.begin, b.width);
}

}  // namespace ferrule
