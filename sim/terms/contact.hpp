// Wall and adhesion, at the two places where the fibre can touch.
//
// The side's contact is a patch some kPatch wide, which the fibre's end cuts where it is near the
// mouth: its energy and friction fade with the length l of the side that is past it
// (ContactSide::past_mouth), by p^3 (10 - 15 p + 6 p^2), p = l/kPatch. So a fibre slides off the
// rim, and what adhesion gave is paid back meanwhile.
//
// The paper knows one contact between fibre and bore; where end and side touch at once (the fibre
// lies along the wall) its printed adhesion and friction are shared between them in equal parts.
#pragma once

#include <algorithm>

#include "sim/terms/potential.hpp"

namespace ferrule {

inline constexpr double kPatch = 0.5e-6;  // diameter of a contact 1 nm deep [m]

// The share of the side's patch that the end leaves, by the length of the side past the mouth.
struct PatchShare {
  double value, slope, curve;  // [-], [1/m], [1/m^2]

  explicit PatchShare(double length) noexcept {
    const double p = std::clamp(length / kPatch, 0.0, 1.0), rest = 1 - p;
    value = p * p * p * (10 - p * (15 - 6 * p));
    slope = 30 * p * p * rest * rest / kPatch;
    curve = 60 * p * rest * (1 - 2 * p) / (kPatch * kPatch);
  }
};

// The share of the side's patch that is there at `tip`.
double side_share(const World& world, const FrozenCoefficients& frozen,
                  const PoseVector& tip) noexcept;

// Of wall and adhesion at a depth [m], or -infinity where nothing touches.
ContactForce push_at(const World& world, double depth) noexcept;
AdhesionForce pull_at(const World& world, double depth, int branch) noexcept;

// What the end cuts off the side's patch: adds that to the bore's energy, and cuts push and pull
// before ContactTerm adds them.
void cut_patch(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
               Potential& potential) noexcept;

// Wall and adhesion. Adds to the bore's energy; reports what the end cuts off, too.
struct ContactTerm {
  static void add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  Potential& potential) noexcept;
  static void report(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                     const Potential& potential, Breakdown& b) noexcept;
};

// The contacts at a pose (sticking points not moved) and the bridge there.
struct Contacts {
  std::array<ContactState, kContactPlaces> contact;
  bool bridge = false;
};
Contacts contacts(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  const Potential& potential) noexcept;

// Does a contact or the bridge begin, end or change its branch?
bool contact_set_changed(const State& before, const Contacts& now) noexcept;

}  // namespace ferrule
