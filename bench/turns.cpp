#include "bench/turns.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <functional>
#include <numbers>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

constexpr double kStep = 1e-3;
constexpr double kOff = 1e-6;  // [clearances]
const Matrix2d kQuarter = (Matrix2d() << 0, -1, 1, 0).finished();
const Matrix2d kAny = Eigen::Rotation2Dd(37 * std::numbers::pi / 180).toRotationMatrix();
const Matrix2d kMirror = Eigen::Vector2d(1, -1).asDiagonal();

Pose turned(const Matrix2d& turn, Pose p) {
  p.segment<2>(1) = (turn * p.segment<2>(1)).eval();
  p.tail<2>() = (turn * p.tail<2>()).eval();
  return p;
}

// The end's largest distance from where it should be [clearances].
double difference(const World& world, const State& start, const std::vector<Pose>& hand,
                  const Matrix2d& turn) {
  State other = start;
  other.tip = turned(turn, start.tip);
  other.command = turned(turn, start.command);
  StepResult here(start), there(other);
  double most = 0;
  for (const Pose& to : hand) {
    step_on(world, to, kStep, here);
    step_on(world, turned(turn, to), kStep, there);
    most = std::max(most, (turned(turn, here.state.tip) - there.state.tip).head<3>().norm());
  }
  return most / world.annulus.clearance();
}

TurnRow measured(const std::string& name, Motion motion, std::uint64_t seed, std::size_t starts) {
  const Scene scene = load_scene(name, {"laws.gravity=null"});
  TurnRow row;
  row.scene = name;
  row.motion = ferrule::name(motion);
  for (std::size_t k = 0; k < starts; ++k) {
    const State start = draw_start(scene, seed, k);
    const std::vector<Pose> hand = commands(scene, start, motion, kStep, seed, k);
    const auto off = [&](const Matrix2d& turn, double& most) {
      const double by = difference(scene.world, start, hand, turn);
      most = std::max(most, by);
      return by > kOff;
    };
    const bool quarter = off(kQuarter, row.quarter), any = off(kAny, row.any);
    const bool mirrored = off(kMirror, row.mirrored);
    ++row.starts;
    row.off += quarter || any || mirrored;
  }
  return row;
}

}  // namespace

std::vector<TurnRow> bench_turns(std::uint64_t seed, std::size_t starts, const GoOn& go_on) {
  Cases<TurnRow> cases;
  for (const std::string& name : shipped_scenes())
    for (const Motion motion : {Motion::insertion, Motion::press})
      add_case(cases, [=] { return measured(name, motion, seed, starts); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
