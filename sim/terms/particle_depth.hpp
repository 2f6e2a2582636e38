// How deep the fibre is in a particle on the wall of the bore (sim/laws/particle.hpp), as a
// function of its pose.
//
// Its side, at e + (x' - x) tilt from the axis, begins at X = x + rho - (r - rho) u.(tilt + cleave)
// on the particle's side, the rim ahead of that being rounded to rho, in second order
// (x' - X)^2/(2 rho) off. It is as deep as where it is deepest, with C the room between fibre and
// wall there (c, in an oval bore that in the direction u) and L = u.tilt,
//   d = max over x' of u.(e + (x' - x) tilt) + b(x') - C - [x' < X] (x' - X)^2/(2 rho)
//     = u.(e - (s_p + x) tilt) + h L^2/2 + h - C - [w > 0] w^2/(2 (h + rho)),
//   w = X + s_p - h L:
// so the end goes over it as over a ramp of the curvature 1/(h + rho), and its side lies on it. A
// sharp rim is the limit rho = 0.
#pragma once

#include "sim/model/world.hpp"

namespace ferrule {

struct ParticleDepth {
  double value = 0;  // d [m]; > 0 where it touches
  // Its derivatives by the pose.
  PoseVector slope;
  PoseMatrix curve;
  // Where it acts [m]: so that the wrench of -slope there is minus the gradient.
  Vector3d point = Vector3d::Zero();
};

// Of a world with a particle, of a height > 0.
ParticleDepth particle_depth(const World& world, const PoseVector& tip) noexcept;

// What it pushes with, along -slope, at a depth [m].
ContactForce particle_push(const Particle& law, double depth) noexcept;

}  // namespace ferrule
