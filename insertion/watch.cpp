#include "insertion/watch.hpp"

#include <array>

namespace ferrule {
namespace {

constexpr std::array<const char*, kOutcomes> kNames = {
    "inserted",       "force_limit",   "jam",         "missed",     "timeout", "buckled",  "broken",
    "invalid_output", "stopped_short", "interrupted", "infeasible", "gave_up", "high_loss"};

}  // namespace

const char* name(Outcome outcome) noexcept {
  return kNames[static_cast<std::size_t>(outcome)];
}

Outcome outcome_from_name(const std::string& text) {
  for (int i = 0; i < kOutcomes; ++i)
    if (text == kNames[static_cast<std::size_t>(i)]) return static_cast<Outcome>(i);
  throw BadInput("\"" + text + "\" is not an outcome");
}

InsertionWatch::InsertionWatch(const Scene& scene, const State& start) noexcept
    : scene_(scene), tip_before_(start.tip) {}

std::optional<Outcome> InsertionWatch::after(const StepResult& result) noexcept {
  if (result.evaluations == 0) return after(result, nullptr);
  const Breakdown now = forces(scene_.world, result);
  return after(result, &now[Term::friction]);
}

std::optional<Outcome> InsertionWatch::after(const StepResult& result,
                                             const TermForces* friction) noexcept {
  const State& now = result.state;
  const double force = holder_force(scene_.world, result.holder).squaredNorm();  // [N^2]
  summary_.time = now.time;
  if (force > summary_.peak_force * summary_.peak_force) summary_.peak_force = std::sqrt(force);
  if (friction) {
    const Vector3d move = (now.tip - tip_before_).head<3>();
    for (const PointForce& at : *friction)
      summary_.friction_work += std::max(0.0, -at.force.dot(move));
    tip_before_ = now.tip;
  }
  summary_.peak_stress =
      std::max(summary_.peak_stress, scene_.world.holder.bending_stress(now.tip, now.command));
  summary_.depth = now.inserted_length();
  if (summary_.reached < 0 && summary_.depth >= scene_.success.depth) summary_.reached = now.time;
  if (summary_.touched < 0 && (now.contact[kEnd].closed || now.contact[kSide].closed))
    summary_.touched = now.time;
  if (now.tip[0] >= 0) summary_.outside = now.time;
  summary_.tip = now.tip;
  summary_.offset = now.tip.segment<2>(1).norm();
  summary_.tilt = now.tip.tail<2>().norm();
  ++summary_.steps;
  summary_.unfinished +=
      result.status == StepStatus::iteration_limit || result.status == StepStatus::not_converged;

  if (result.status == StepStatus::bad_command) return Outcome::invalid_output;
  if (force > scene_.limits.force * scene_.limits.force) {
    if (now.contact[kEnd].closed && now.side == EdgeSide::face) return Outcome::missed;
    if (now.contact[kEnd].closed && now.contact[kSide].closed) return Outcome::jam;
    return Outcome::force_limit;
  }
  if (result.holder[0] > scene_.world.holder.euler_load) return Outcome::buckled;
  if (summary_.peak_stress > scene_.limits.proof_stress) return Outcome::broken;
  if (summary_.depth >= scene_.success.depth)
    return joint_loss_dB(scene_.joint, light_axis(scene_.joint, now.tip)) <= scene_.success.loss_dB
               ? Outcome::inserted
               : Outcome::high_loss;
  if (now.time >= scene_.limits.time) return Outcome::timeout;
  return std::nullopt;
}

}  // namespace ferrule
