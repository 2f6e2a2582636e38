// What the operator's window shows of one tick: a frame, made of a row (capture/row.hpp), so that
// an insertion that runs and one that was recorded look the same.
//
// The table in view/frame.cpp says what the columns are. All are at the tip's scale, in the frame of
// sim/geometry/pose.hpp (x out of the bore, y up, z to the viewer; insertion is motion along -x), in
// the units that end their names.
#pragma once

#include <string>
#include <vector>

#include "capture/row.hpp"
#include "insertion/phase.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/sensed_wrench.hpp"

namespace ferrule {

inline constexpr int kFrameColumns = 44 + 3 * static_cast<int>(kTerms);
using Frame = std::array<float, kFrameColumns>;
// Their names, in order.
std::vector<std::string> frame_columns();

// Of the loop so far; 0 where there is none in time.
struct LoopHealth {
  double period = 0, worst = 0;  // the last and the longest [s]
  double missed = 0;             // deadlines
  double passivity = 0;          // energy that the hand has put in, < 0: was given [J]
};

// Makes the frames of one insertion in `scene`, which outlives it.
class FrameMaker {
 public:
  // `sensor`: that of the insertion, at its start; `period` [s] between rows.
  FrameMaker(const Scene& scene, const ForceSensor& sensor, double period) noexcept;

  // Of every row in turn, the first at rest.
  Frame operator()(const RowVector& row, const LoopHealth& health = {}) noexcept;

 private:
  const Scene& scene_;
  Scaling scaling_;
  SensedWrench sensed_;
  std::optional<InsertionWatch> watch_;  // since the first row
  std::array<ContactState, kContactPlaces> contact_before_;
  PhaseWatch phase_;
};

// What a page draws of a scene: {"name", "about", "geometry", "limits": {"force_uN", "speed_um_s",
// "time_s"}, "start": {"distance_um"}, "success_depth_um", "cue", "terms": names of those that
// act}.
// "geometry" [um]: fibre_radius, bore_radius, bore_length, lead_in_length (0: none), mouth_radius;
// free_length of an elastic fibre (0: a rigid hand), whose clamp is at holder + free_length (1, ay,
// az); "liquid": {"film", "rupture"} where a film is modelled.
Json scene_json(const Scene& scene);

}  // namespace ferrule
