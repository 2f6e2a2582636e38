// What a step leaves for the one after it, beside its result: a warm start. It does not
// belong to the state. A step from the state alone takes an evaluation more and ends elsewhere by less than the
// tolerances of solver and extrapolation, which the next snap magnifies.
#pragma once

#include <array>
#include <cmath>
#include <optional>

#include "sim/geometry/energy.hpp"
#include "sim/model/state.hpp"

namespace ferrule {

// The surface and contact forces linearised about the pose a step ended at: the predictor of the
// next step (sim/solver/predictor.hpp).
struct Linearization {
  Pose at = Pose::Constant(NAN);  // [m, rad]; not the state's: there is none
  PoseVector gradient = {};       // of their energy [N, N m]
  PoseMatrix hessian = {};        // [N/m, N/rad, N m/rad]
  PoseVector curvature = {};      // what the last move changed the gradient by beyond the Hessian
};

// How the fibre follows the hand where nothing happens, to first order about the pose at which a
// step was solved (sim/solver/extrapolation.hpp).
struct Extrapolation {
  Matrix5 tip_by_command;
  // Where drag is modelled: by the move over the step before, which was `last`, and how long a step
  // is [s].
  Matrix5 tip_by_last = Matrix5::Zero();
  Pose last = Pose::Zero();
  double dt = 0;
  double arc_length = 0;           // how far the fibre has gone since [-]
  double trust_radius = 0;         // how far it may go until a step is solved again [-]
  double determinant = 0;          // of the stiffness that holds the end [(N/m)^3 (N m/rad)^2]
  double least_x = 0, most_x = 0;  // the end stays between edges of the ferrule [m]
  struct Place {
    bool open = false;  // an open contact that is near
    bool friction_acts = false, slides = false;
    double depth = 0;       // of mean surfaces: now where it is open, else in the step solved [m]
    double limit_slip = 0;  // elastic slip at the friction limit [m]
    double limit_by_depth = 0;  // of that, by the depth [-]
    double beyond = 0;          // slip beyond the limit, in the step solved [m]
    double lateral = 0;         // slip across the sliding direction of the step solved [m]
    Pose depth_slope = Pose::Zero();
    Vector3d slip = Vector3d::Zero();  // elastic [m]
    Vector3d lateral_direction = Vector3d::Zero();
    Pose tip_by_lateral = Pose::Zero();
    Eigen::Matrix<double, 3, 5> slip_by_tip = Eigen::Matrix<double, 3, 5>::Zero();
  };
  std::array<Place, kContactPlaces> place;

  // With copies of its own, so that a state without one costs none.
  Extrapolation() = default;
  Extrapolation(const Extrapolation& other) noexcept { *this = other; }
  Extrapolation& operator=(const Extrapolation&) = default;
};

struct WarmStart {
  Linearization linearization;
  std::optional<Extrapolation> extrapolation;  // without it the next step is solved
  Breakdown forces;                            // where a step was solved last
};

}  // namespace ferrule
