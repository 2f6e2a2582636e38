// Clearance means clearance: which starts let a rigid upright fibre into the bore.
#pragma once

#include <vector>

namespace ferrule {

struct CaptureRow {
  double offset_clearances;  // start offset over the radial clearance, or over the capture radius
  double direction_deg, speed_um_s, step_s;
  bool lead_in;   // against the geometric capture range of a lead-in cone
  bool inserted;  // it went in
  bool expected;  // offset below 1
};

// No surface forces, no friction, tilt fixed; lowered straight along -x at 5 and 50 um/s in steps
// of 0.1, 1 and 10 ms from offsets of 0.5 to 30 clearances in eight directions. A sharp bore must
// take exactly those below 1 clearance; with a lead-in, those below its rim (offset below 1 of
// mouth radius - fibre radius).
std::vector<CaptureRow> bench_capture();

}  // namespace ferrule
