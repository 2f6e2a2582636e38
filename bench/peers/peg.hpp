// A cylindrical peg in a sharp-edged bore as other engines are given it, and how they are asked.
//
// Fibre and bore are those of the scene `paper`, magnified kDrawn times, as its haptic scaling
// magnifies them: engines are made for things of centimetres and more. The bore is the x axis at
// x <= 0; as general engines collide convex bodies, its wall is a ring of boxes that touch the
// bore's circle with the middle of their inner face. The peg is a free body. A holder pulls it by
// its end: a spring in the end's position and in the tilts, as that of a rigid hand
// (sim/model/holder.hpp), with critical damping relative to the hand's velocity. No gravity, no
// friction: what is right then is known in closed form (bench/peers.hpp). The mass is the drawn
// fibre's; the forces scale so that the spring is the scene's.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace ferrule::peers {

using Eigen::Quaterniond;
using Eigen::Vector3d;

inline constexpr double kDrawn = 250;                                     // alpha_x of the paper
inline constexpr double kPeg = 62.5e-6 * kDrawn, kBore = 63e-6 * kDrawn;  // radii [m]
inline constexpr double kPegLength = 0.6e-3 * kDrawn, kBoreLength = 0.5e-3 * kDrawn;  // [m]
inline constexpr double kWall = 60e-6 * kDrawn;  // thickness [m]
inline constexpr double kMass = 2200 * std::numbers::pi * kPeg * kPeg * kPegLength;  // [kg]
// About the axis, and about the others through the centre [kg m^2].
inline constexpr double kSpin = 0.5 * kMass * kPeg * kPeg;
inline constexpr double kTurn = kMass * (3 * kPeg * kPeg + kPegLength * kPegLength) / 12;

// A box of the ring: its middle, half its edges, and the angle by which it is turned about x.
struct Box {
  Vector3d middle, half;
  double angle;
};
inline std::vector<Box> ring(int segments) {
  std::vector<Box> boxes;
  for (int i = 0; i < segments; ++i) {
    const double angle = 2 * std::numbers::pi * i / segments, out = kBore + 0.5 * kWall;
    boxes.push_back(
        {{-0.5 * kBoreLength, out * std::cos(angle), out * std::sin(angle)},
         {0.5 * kBoreLength, 0.5 * kWall, (kBore + kWall) * std::tan(std::numbers::pi / segments)},
         angle});
  }
  return boxes;
}

// Of the peg, whose axis is x where nothing turned it; at its centre, in the frame of the bore.
struct Motion {
  Vector3d at = Vector3d::Zero();
  Quaterniond turned = Quaterniond::Identity();
  Vector3d velocity = Vector3d::Zero(), spin = Vector3d::Zero();
};

// A world of some engine with ring and peg in it.
class Engine {
 public:
  virtual ~Engine() = default;
  // At rest there, with nothing remembered of before.
  virtual void reset(const Vector3d& at) = 0;
  // Lets a force at the centre and a moment act for one step.
  virtual void step(const Vector3d& force, const Vector3d& moment) = 0;
  virtual Motion motion() const = 0;
};

// An engine with its settings.
struct Peer {
  std::string engine, version, settings;
  int segments;
  double step;  // [s]
  std::function<std::unique_ptr<Engine>()> make;
};
using Peers = std::vector<Peer> (*)();

}  // namespace ferrule::peers
