// One row of a demonstration: a tick of the loop (insertion/loop.hpp) as numbers.
//
// Row n, at time t_n:
//   the hand is at pose_hand(t_n); the simulator has stepped to it, which gives the state and the
//   forces at t_n; the hand feels them and moves on: `command` is its velocity over [t_n, t_n+1).
// So a row pairs a force with the velocity that answers it, never with the one that caused it.
#pragma once

#include <Eigen/Core>
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
  const char* unit;
  const char* columns;
};

inline constexpr int kPose = 5;
inline constexpr Block kTime{"time", 0, 1, "s", "t"};
inline constexpr Block kHandPose{"hand_pose", 1, 5, "m m m rad rad", "x y z tilt_y tilt_z"};
inline constexpr Block kHandVelocity{"hand_velocity", 6, 5, "m/s m/s m/s rad/s rad/s",
                                     "x y z tilt_y tilt_z; over [t_n-1, t_n)"};
inline constexpr Block kCommand{"command", 11, 5, "m/s m/s m/s rad/s rad/s",
                                "x y z tilt_y tilt_z; of the hand over [t_n, t_n+1)"};
inline constexpr Block kHolder{"holder_wrench", 16, 5, "N N N N.m N.m",
                               "Fx Fy Fz My Mz; at the tip's scale, of the fibre on the hand"};
// "x y z of each of " and the names of the table of terms.
inline constexpr auto kForceColumns = [] {
  constexpr std::string_view head = "x y z of each of";
  constexpr std::size_t size = [head] {
    std::size_t sum = head.size() + 1;
    for (const char* name : kTermNames) sum += 1 + std::string_view(name).size();
    return sum;
  }();
  std::array<char, size> text{};
  std::size_t at = 0;
  for (const char c : head) text[at++] = c;
  for (const char* name : kTermNames) {
    text[at++] = ' ';
    for (const char c : std::string_view(name)) text[at++] = c;
  }
  return text;
}();
inline constexpr Block kForces{"forces", 21, 3 * static_cast<int>(kTerms), "N",
                               kForceColumns.data()};
// Where a term's force begins in a row.
constexpr int force_column(Term term) noexcept {
  return kForces.begin + 3 * static_cast<int>(term);
}
inline constexpr Block kStatus{"status", kForces.begin + kForces.width, 1, "1",
                               "0 ok, 1 not converged, 2 bad command, 3 capped"};
inline constexpr Block kStates{
    "states", kStatus.begin + 1, kStateSize, "m, rad, s",
    "tip: x y z tilt_y tilt_z; hand at the tip's scale: x y z tilt_y tilt_z; time; on_face; "
    "bridge; "
    "end contact: closed depth stuck_x stuck_y stuck_z branch; side contact: the same; "
    "velocity (5); tip before (5); velocity before (5); period before; air"};
inline constexpr int kRowSize = kStates.begin + kStateSize;
inline constexpr std::array kBlocks = {kTime,   kHandPose, kHandVelocity, kCommand,
                                       kHolder, kForces,   kStatus,       kStates};

using RowVector = Eigen::Matrix<double, 1, kRowSize>;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, kRowSize, Eigen::RowMajor>;

// The names of a block's columns, one each; of the forces also those of its first columns.
std::vector<std::string> column_names(const Block& block);

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
