// The joint that a grade of connectors is for: what the scene states of it, and what is assumed
// where it states nothing. Without that a grade would be one of perfect cores and bores, at one
// wavelength. Only grades assume it; the loss with an ideal partner is that of Scene::joint.
//
//   wavelength_nm             1310 and 1550
//   mode_field_diameter_um    9.2 at 1310 nm and 10.4 at 1550 nm (usual for G.652), on a line
//                             through both at others
//   core_concentricity_sd_um  0.2, and bore_concentricity_sd_um 0.3, unless the scene states the
//                             offset itself (data/README.md says why)
//   index, gap_um             those of Joint: 1.4682, and ends that touch
#pragma once

#include <string>
#include <vector>

#include "sim/scene/scene.hpp"

namespace ferrule {

struct GradedJoint {
  std::vector<Joint> at;                   // the same joint at each wavelength; not empty
  std::optional<double> core_sd, bore_sd;  // [m]; empty where the scene states the offset itself
  double unstated_sd = 0;            // of core and bore together, what the scene does not draw [m]
  std::vector<std::string> assumed;  // the keys of `joint` that the scene does not state

  // What the light of a connector is off besides in that trial, because of `unstated_sd` [m]. If
  // core and bore are both assumed, it is what a scene that states them draws.
  Vector2d unstated_offset(std::uint64_t seed, std::uint64_t trial) const;
};

GradedJoint graded_joint(const Scene& scene);

// "1310 and 1550 nm, mode fields 9.2 and 10.4 um, core off by 0.2 um and bore by 0.3 um (standard
// deviations in y and z), ends that touch; all of it assumed".
std::string to_text(const GradedJoint& joint);
Json to_json(const GradedJoint& joint);

}  // namespace ferrule
