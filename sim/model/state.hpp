// What changes while a fibre is inserted.
#pragma once

#include <array>
#include <optional>
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

// The surface and contact forces linearised about the pose a step ended at: the predictor of the
// next step (sim/solver/step.cpp). Without it a step takes an evaluation more, and ends some 1e-6
// clearances elsewhere, which the next snap magnifies.
struct Linearization {
  Pose at = Pose::Zero();  // [m, rad]
  PoseVector gradient;     // of their energy [N, N m]
  PoseMatrix hessian;      // [N/m, N/rad, N m/rad]
  PoseVector curvature;    // what the last move changed the gradient by beyond the Hessian
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
  std::optional<Linearization> linearization;
  std::optional<Extrapolation> extrapolation;  // without it the next step is solved

  // Inserted length l_f [m], >= 0.
  double inserted_length() const noexcept { return tip[0] < 0 ? -tip[0] : 0.0; }
};

// A state as a row of numbers: for files and for comparing bit for bit. What goes on from it goes
// on from that state to the last bit.
inline constexpr int kLinearized = 42;  // column that tells whether there is a linearization
inline constexpr int kExtrapolated = kLinearized + 1 + 5 + 17 + 5;  // and whether an extrapolation
inline constexpr int kExtrapolationSize = 2 * 25 + 5 + 6 + kContactPlaces * 39;
inline constexpr int kStateSize = kExtrapolated + 1 + kExtrapolationSize;
using StateRow = Eigen::Matrix<double, kStateSize, 1>;

// Shows `each` the parts of an extrapolation, in the order of a row.
template <class OfExtrapolation, class Each>
void each_part(OfExtrapolation& e, const Each& each) noexcept {
  each(e.tip_by_command.reshaped());
  each(e.tip_by_last.reshaped());
  each(e.last);
  for (auto* number :
       {&e.dt, &e.arc_length, &e.trust_radius, &e.determinant, &e.least_x, &e.most_x})
    each(*number);
  for (auto& place : e.place) {
    for (auto* flag : {&place.open, &place.friction_acts, &place.slides}) each(*flag);
    for (auto* number :
         {&place.depth, &place.limit_slip, &place.limit_by_depth, &place.beyond, &place.lateral})
      each(*number);
    each(place.depth_slope);
    each(place.slip);
    each(place.lateral_direction);
    each(place.tip_by_lateral);
    each(place.slip_by_tip.reshaped());
  }
}

inline StateRow to_row(const State& s) noexcept {
  StateRow row = StateRow::Zero();
  row.head<kLinearized>() << s.tip, s.command, s.time, s.side == EdgeSide::face ? 1.0 : 0.0,
      s.bridge ? 1.0 : 0.0, StateRow::Zero().head<12>(), s.velocity, s.tip_before,
      s.velocity_before, s.dt_before, s.air;
  for (int place = 0; place < kContactPlaces; ++place) {
    const ContactState& c = s.contact[place];
    row.segment<6>(13 + 6 * place) << (c.closed ? 1.0 : 0.0), c.depth, c.stuck,
        static_cast<double>(c.branch);
  }
  if (s.linearization && s.linearization->at == s.tip) {
    const PoseMatrix& h = s.linearization->hessian;
    row.segment<kExtrapolated - kLinearized>(kLinearized) << 1, s.linearization->gradient.full(),
        h.xx, h.xe, h.xt, h.ee.reshaped(), h.et.reshaped(), h.tt.reshaped(),
        s.linearization->curvature.full();
  }
  if (!s.extrapolation) return row;
  Eigen::Index at = kExtrapolated;
  row[at++] = 1;
  each_part(*s.extrapolation, [&](const auto& part) {
    if constexpr (std::is_arithmetic_v<std::decay_t<decltype(part)>>) {
      row[at++] = static_cast<double>(part);
    } else {
      row.segment(at, part.size()) = part;
      at += part.size();
    }
  });
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
  if (row[kExtrapolated] != 0) {
    Eigen::Index at = kExtrapolated + 1;
    each_part(s.extrapolation.emplace(), [&](auto&& part) {
      using Part = std::decay_t<decltype(part)>;
      if constexpr (std::is_arithmetic_v<Part>) {
        part = static_cast<Part>(row[at++]);
      } else {
        part = row.segment(at, part.size());
        at += part.size();
      }
    });
  }
  if (row[kLinearized] == 0) return s;
  Linearization& l = s.linearization.emplace();
  l.at = s.tip;
  l.gradient = PoseVector(row.segment<5>(43));
  const Eigen::Matrix<double, 17, 1> h = row.segment<17>(48);
  l.hessian.xx = h[0];
  l.hessian.xe = h.segment<2>(1);
  l.hessian.xt = h.segment<2>(3);
  l.hessian.ee = h.segment<4>(5).reshaped(2, 2);
  l.hessian.et = h.segment<4>(9).reshaped(2, 2);
  l.hessian.tt = h.segment<4>(13).reshaped(2, 2);
  l.curvature = PoseVector(row.segment<5>(65));
  return s;
}

}  // namespace ferrule
