// Clearance means clearance: which starts let a rigid upright fibre into the bore.
#pragma once

#include <vector>

#include "bench/cases.hpp"

namespace ferrule {

struct CaptureRow {
  double offset_clearances;  // start offset over the radial clearance
  // Offsets below this are caught: 1, with a lead-in that of its rim, with a rounded rim of the end
  // its radius more, with a cleaved end what its direction says.
  double capture_clearances;
  double direction_deg, speed_um_s, step_s;
  double edge_um, cleave_deg;
  bool lead_in;
  bool inserted;  // it went in
  bool expected() const { return offset_clearances < capture_clearances; }
};

// No surface forces, no friction, tilt fixed; lowered straight along -x at 5 and 50 um/s in steps
// of 0.1, 1 and 10 ms from offsets of 0.5 to 30 clearances in eight directions. A sharp bore must
// take exactly those below 1 clearance. With a lead-in the same, and offsets of 0.9 to 3 times its
// geometric capture range, mouth radius - fibre radius; it must take exactly those below that. The
// same with ends as they are: rims rounded to 1, 5 and 10 um, square, at 0.9 to 3 times clearance +
// radius over a sharp bore, mouth radius - fibre radius + radius over a cone, in steps of 1 and 10
// ms. And cleaved at 0.5 and 1 degree over a sharp bore, at 0.9 to 3 times where the
// foremost point of the rim leaves the opening, in directions up to 90 degrees from that point:
// within that an end that rests on the edge with its inclined face slides in, without friction, as
// the hand presses on by 20 times the way; beyond it rests on its foremost point. (A hand that
// presses a thousand times as far as that point is outside draws it in: by what smooths the rest of
// a level end, sim/geometry/face_support.hpp.)
std::vector<CaptureRow> bench_capture(const GoOn& go_on = {});

}  // namespace ferrule
