// The same peg in the same hole in general engines, beside ours: time, error, and what they let in.
//
// Geometry and holder are those of bench/peers/peg.hpp. Two cases, both without friction:
//
//   motion   400 um deep, the hand goes 1.5 um to one side and 0.5 mrad beyond the tilt at which
//            the fibre touches with its end on one wall and with its side on the mouth opposite,
//            then once around the axis in 6 s, the depth swinging by 50 um. What is right is the
//            least energy of the holder's spring among the poses in which the fibre is within the
//            bore at end and mouth: a quadratic programme in the plane of the hand's offset.
//   let in   the hand lowers an upright fibre straight from 2 um above the face to 8 um below it,
//            from 4 to 60 clearances beside the axis, in four directions. None fits. (Within 2
//            clearances it does go in: the face tilts the fibre by up to 1 mrad against its
//            holder, which lets it slide down the mouth's edge.)
#pragma once

#include <string>
#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct PeerRow {
  std::string engine, version, settings;
  int segments;  // boxes that make the bore; 0: it is round
  double step_s;
  double us_per_simulated_ms;   // processor time, in the motion
  double pose_error_um;         // largest, sideways at end and mouth
  double force_error_relative;  // of the holder's sideways force, over the largest that is right
  double penetration_um;        // largest, of end and mouth into the round bore
  int outside, let_in;          // starts beside the bore, and those that went in
};

struct PeerBench {
  std::vector<PeerRow> rows;
  std::vector<std::string> missing;  // engines that the program was built without, and what to do
};

PeerBench bench_peers(const GoOn& go_on = {});

// Of a fibre within the clearance `c` at the end and at `length` from it, the one with the least
// k (e - hand_e)^2 + k_tilt (tilt - hand_tilt)^2: its e and tilt (in one plane) [m, rad].
struct PlanarPose {
  double e, tilt;
};
PlanarPose held_in_bore(PlanarPose hand, double length, double c, double k, double k_tilt) noexcept;

}  // namespace ferrule
