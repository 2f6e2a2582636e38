#include "sim/terms/nonsmooth.hpp"

#include <cmath>

#include "sim/terms/contact.hpp"
#include "sim/terms/particle.hpp"
#include "sim/terms/particle_depth.hpp"
#include "sim/terms/printed_well.hpp"

namespace ferrule {

std::array<NonsmoothTerm, kNonsmoothTerms> nonsmooth_terms(const World& world,
                                                           const FrozenCoefficients& frozen,
                                                           const PoseVector& tip,
                                                           double side_share) noexcept {
  std::array<NonsmoothTerm, kNonsmoothTerms> laws;
  const auto depths = contact_depths(world, frozen.contact, tip);
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactDepth& depth = depths[place];
    if (depth.value == -INFINITY) continue;
    const ContactForce push = push_at(world, depth.value);
    const AdhesionForce pull = pull_at(world, depth.value, frozen.branch[place]);
    const double share = place == kSide ? side_share : 1.0;
    const double adhesion = share * frozen.adhesion_share;
    laws[place] = {share,
                   true,
                   depth.value,
                   depth.by_pose(tip.t),
                   share * push.potential + adhesion * pull.potential,
                   share * push.force + adhesion * pull.force,
                   share * push.slope + adhesion * pull.slope};
  }
  if (particle_acts(world, frozen)) {
    const ParticleDepth there = particle_depth(world, tip);
    const ContactForce push = particle_push(*world.laws.particle, there.value);
    laws[kInParticle] = {1, true, there.value, there.slope, push.potential, push.force, push.slope};
  }
  const double arm = printed_arm(world, frozen);
  if (arm == 0) return laws;
  const double clearance = world.annulus.clearance(), length = printed_length(world, frozen);
  const Radial middle(eccentricity(world.oval.stretched(tip), arm), clearance);
  const double gap = clearance - middle.eccentricity;
  const Vector2d out = world.oval.stretch * middle.normal;
  const LineForce force = printed_forces(world, gap);
  laws[kPrintedWell] = {1,
                        true,
                        -gap,
                        {0, out, arm * out},
                        length * force.potential,
                        length * force.force,
                        -length * force.slope,
                        world.oval.stretch * middle.curving * world.oval.stretch,
                        arm};
  return laws;
}

}  // namespace ferrule
