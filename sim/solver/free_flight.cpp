#include "sim/solver/free_flight.hpp"

#include <algorithm>
#include <cmath>

#include "sim/geometry/contact_depth.hpp"

namespace ferrule {
namespace {

// Nothing near the fibre now or at its `goal`.
bool flies_free(const World& world, const State& state, const Pose& goal) noexcept {
  const double lever = world.annulus.fibre_radius;
  const auto steepest = [](const auto& slope) { return std::abs(slope[0]) + std::abs(slope[1]); };
  const double clear_beyond =
      world.profile.lead_in_length + world.annulus.clearance() + lever * steepest(world.end.cleave);
  const double nearest = std::min(state.tip[0], state.command[0]);
  if (!(nearest > clear_beyond)) return false;
  return std::min(nearest, goal[0]) -
             lever * (steepest(state.tip.tail<2>()) + steepest(goal.tail<2>())) >
         clear_beyond;
}

// How far the rim of an end at `p` is at least from the walls of the opening, across the bore,
// where all of it is in front of the bore [m]; else negative.
double room_across(const World& world, const Pose& p) noexcept {
  const FerruleProfile& profile = world.profile;
  const double r = world.annulus.fibre_radius;
  const double low = p[0] - r * (p.tail<2>().norm() + world.end.cleave.norm());
  if (!(low > 0)) return -1;
  const double wall =
      profile.bore_radius + std::min(low, profile.lead_in_length) * profile.lead_in_tangent;
  return wall - world.oval.amplitude - p.segment<2>(1).norm() - r;
}

// In the opening before and after, and so all the way, its free part being convex, and too far from
// its walls to adhere. A particle may reach out of the bore.
bool hangs_in_opening(const World& world, const State& state, const Pose& goal) noexcept {
  if (!(std::min(state.tip[0], goal[0]) > 0) || world.laws.particle || state.contact[kEnd].closed)
    return false;
  const double across = std::min(room_across(world, state.tip), room_across(world, goal));
  const double cosine = world.profile.lead_in_cosine();
  // A rim that is rounded for the throat alone touches the cone earlier.
  const double earlier = (1 - cosine) * (world.end.rounding() - world.end.edge);
  const double room = cosine * across - earlier;
  if (!(room > 0)) return false;
  const AdhesionForce pull = adhesion_force(world.laws, -room, 0);
  return pull.force == 0 && pull.branch == 0;
}

}  // namespace

bool fly_free(const World& world, const Pose& command, double dt, StepResult& now) noexcept {
  State& state = now.state;
  if (world.dynamics == Dynamics::inertial) return false;
  const Pose goal = command + world.holder.sag;
  const bool in_opening = !flies_free(world, state, goal);
  if (in_opening && !hangs_in_opening(world, state, goal)) return false;
  // What a free step before this one has cleared is clear.
  const bool was_free = now.substeps > 0 && now.evaluations == 0 && !now.warm_start.extrapolation;
  if (!was_free) {
    state.bridge = false;
    state.air = 0;
    state.contact = {};
    now.warm_start.linearization = {};
    now.warm_start.extrapolation.reset();
  }
  state.tip = goal;
  state.command = command;
  state.time += dt;
  if (in_opening) state.side = EdgeSide::throat;
  now.warm_start.linearization.at = in_opening ? state.tip : Pose::Constant(NAN);
  now.holder = world.holder.weight;
  now.status = StepStatus::ok;
  now.evaluations = now.iterations = now.rejected = 0;
  now.substeps = 1;
  return true;
}

}  // namespace ferrule
