#include "sim/terms/particle.hpp"

#include "sim/terms/particle_depth.hpp"

namespace ferrule {

bool particle_acts(const World& world, const FrozenCoefficients& frozen) noexcept {
  return world.laws.particle && frozen.contact.side == EdgeSide::throat;
}

void ParticleTerm::add(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                       Potential& potential) noexcept {
  if (!particle_acts(world, frozen)) return;
  const ParticleDepth there = particle_depth(world, tip);
  if (!(there.value > 0)) return;
  const ContactForce push = particle_push(*world.laws.particle, there.value);
  Energy& bore = potential.bore;
  bore.value += push.potential;
  bore.value_scale += push.potential;
  bore.force_scale += push.force;
  bore.gradient += push.force * there.slope;
  bore.hessian += push.force * there.curve;
  add_square(bore.hessian, push.slope, there.slope);
}

void ParticleTerm::report(const World& world, const FrozenCoefficients& frozen,
                          const PoseVector& tip, const Potential&, Breakdown& b) noexcept {
  if (!particle_acts(world, frozen)) return;
  const ParticleDepth there = particle_depth(world, tip);
  const double push = particle_push(*world.laws.particle, there.value).force;
  b[Term::particle][0] = {-push * there.slope.position(), there.point};
}

}  // namespace ferrule
