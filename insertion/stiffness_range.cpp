#include "insertion/stiffness_range.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "sim/solver/held_stiffness.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

constexpr double kMostTilt = 0.05;   // slopes beyond are not small [rad]
constexpr double kMostSteps = 2000;  // of one motion; where it is far they are longer
constexpr std::size_t kMotions = 37;

using GoOn = std::function<bool(std::size_t done, std::size_t all)>;

Vector3d eigenvalues(const Eigen::Matrix3d& m) noexcept {
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(m, Eigen::EigenvaluesOnly).eigenvalues();
}

Pose moved(Pose pose, int coordinate, double by) noexcept {
  pose[coordinate] += by;
  return pose;
}

// Drives the hand and looks at every state on its way.
class Probe {
 public:
  Probe(const Scene& scene, double dt, const GoOn& go_on, StiffnessRange& range)
      : scene_(scene), dt_(dt), go_on_(go_on), range_(range) {}

  // The end at rest at `tip`.
  void begin(const Pose& tip) noexcept { state_ = at_rest(scene_.world, tip); }

  // In a straight line of steps of half a clearance to where the end would be at `goal` in free
  // air.
  void drive(const Pose& goal) {
    if (stopped_) return;
    move(goal);
    stopped_ = go_on_ && !go_on_(++done_, kMotions);
  }

  // There and back again.
  void push(const Pose& from, int coordinate, double by) {
    drive(moved(from, coordinate, by));
    drive(from);
  }

 private:
  void move(const Pose& goal) noexcept {
    const World& world = scene_.world;
    const double lever = world.profile.lead_in_length + scene_.success.depth;
    const Pose from = state_.command, to = goal - world.holder.sag;
    const double travel = (to - from).head<3>().norm() + lever * (to - from).tail<2>().norm();
    const double stride = 0.5 * world.annulus.clearance();
    const int steps =
        std::max(1, static_cast<int>(std::min(kMostSteps, std::ceil(travel / stride))));
    for (int i = 1; i <= steps; ++i) {
      const double part = static_cast<double>(i) / steps;
      const StepResult result =
          step(world, state_, i == steps ? to : Pose(from + part * (to - from)),
               travel / steps / scene_.limits.speed);
      state_ = result.state;
      if (holder_force(world, result.holder).norm() > scene_.limits.force) return;
      look();
    }
  }

  void look() noexcept {
    const bool end = state_.contact[kEnd].closed, side = state_.contact[kSide].closed;
    ++range_.states;
    range_.touching += end || side;
    range_.two_point += end && side;
    const Matrix5 at_rest = held_stiffness(scene_.world, state_);
    const Vector3d values = eigenvalues(at_rest.topLeftCorner<3, 3>());
    range_.smallest = std::min(range_.smallest, values[0]);
    if (values[2] > range_.largest) {
      range_.largest = values[2];
      range_.stiffest = state_;
    }
    if (!depends_on_speed(scene_.world.laws) && scene_.world.dynamics == Dynamics::quasi_static)
      return;
    const Matrix5 more = held_stiffness(scene_.world, state_, dt_) - at_rest;
    range_.damping = std::max(range_.damping, dt_ * eigenvalues(more.topLeftCorner<3, 3>())[2]);
  }

  const Scene& scene_;
  double dt_;
  const GoOn& go_on_;
  std::size_t done_ = 0;
  bool stopped_ = false;
  StiffnessRange& range_;
  State state_;
};

}  // namespace

StiffnessRange insertion_stiffness(const Scene& scene, double dt, const GoOn& go_on) {
  const World& world = scene.world;
  const double clearance = world.annulus.clearance(), r = world.annulus.fibre_radius;
  const double depth = scene.success.depth;
  const double sideways = 2 * clearance + scene.limits.force / world.holder.stiffness(1, 1);
  const double forward = 2 * clearance + scene.limits.force / world.holder.stiffness(0, 0);

  StiffnessRange range;
  Probe probe(scene, dt, go_on, range);
  Pose start = Pose::Zero();
  start[0] = scene.start.distance;
  start.segment<2>(1) = scene.start.lateral_mean;
  probe.begin(start);
  start.segment<2>(1).setZero();
  probe.drive(start);
  for (const double inserted : {0.5 * depth, depth}) {
    const Pose inside = moved(Pose::Zero(), 0, -inserted);
    probe.drive(inside);
    for (const int sign : {-1, 1})
      for (const int axis : {1, 2}) {
        probe.push(inside, axis, sign * sideways);
        probe.push(inside, axis + 2, sign * std::min(kMostTilt, 4 * clearance / inserted));
      }
  }

  const double rim = world.profile.mouth_radius(), bore = world.profile.bore_radius;
  for (const double offset : {0.5 * (rim - bore), rim - 0.5 * r}) {
    if (offset == 0) continue;  // a sharp bore has no cone
    Pose before = moved(Pose::Zero(), 1, offset);
    before[0] = std::max(scene.start.distance, world.profile.lead_in_length + 10 * clearance);
    probe.begin(before);
    probe.drive(moved(before, 0, -before[0] - forward));
  }
  return range;
}

}  // namespace ferrule
