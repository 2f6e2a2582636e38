#include "sim/terms/particle_depth.hpp"

namespace ferrule {

ParticleDepth particle_depth(const World& world, const PoseVector& tip) noexcept {
  const Particle& law = *world.laws.particle;
  const double h = law.height, rho = world.end.edge, r = world.annulus.fibre_radius;
  ParticleDepth there;
  const Vector2d& u = law.outward;
  const double wide = u.dot(world.oval.widest);
  const double room = world.annulus.clearance() + world.oval.amplitude * (2 * wide * wide - 1);
  const double tilt = u.dot(tip.t), arm = -law.depth - tip.x;
  there.value = u.dot(tip.e) + (arm + 0.5 * h * tilt) * tilt + h - room;
  there.slope = {-tilt, u, (arm + h * tilt) * u};
  there.curve.xt = -u;
  const Matrix2d square = u * u.transpose();
  there.curve.tt = h * square;
  const double before = rho - arm - (r - rho) * (tilt + u.dot(world.end.cleave)) - h * tilt;
  if (before > 0) {
    const double wider = 1 / (h + rho), lever = r - rho + h;
    const PoseVector by_pose = {1, Vector2d::Zero(), -lever * u};
    there.value -= 0.5 * wider * before * before;
    there.slope -= wider * before * by_pose;
    add_square(there.curve, -wider, by_pose);
  }
  const double along = there.slope.t.dot(u) + r * there.slope.x;
  there.point = tip.position() + Vector3d(along, r * u.x(), r * u.y());
  return there;
}

ContactForce particle_push(const Particle& law, double depth) noexcept {
  return wall({law.reduced_modulus, law.height, 0}, depth);
}

}  // namespace ferrule
