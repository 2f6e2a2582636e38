#include "learn/candidates.hpp"

#include <algorithm>

#include "controller/device_controller.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/fit_law.hpp"
#include "learn/fit_policy.hpp"
#include "learn/fit_search.hpp"
#include "sim/base/measure.hpp"

namespace ferrule {
namespace {

// A recorded hand motion again, whatever is observed.
class RecordedMotion : public Controller {
 public:
  explicit RecordedMotion(std::shared_ptr<const Demonstration> recorded)
      : recorded_(std::move(recorded)) {}

  HandTwist command(const Observation&) noexcept override {
    HandTwist v = HandTwist::Zero();
    if (next_ < recorded_->rows()) v.head<3>() = recorded_->velocity.row(next_++).transpose();
    return v;
  }

 private:
  std::shared_ptr<const Demonstration> recorded_;
  Eigen::Index next_ = 0;
};

std::shared_ptr<const Demonstration> fastest(const DemonstrationSet& set) {
  const auto duration = [](const Demonstration& d) {
    return d.period * static_cast<double>(d.rows());
  };
  return std::make_shared<const Demonstration>(
      *std::min_element(set.demonstrations.begin(), set.demonstrations.end(),
                        [&](const auto& a, const auto& b) { return duration(a) < duration(b); }));
}

}  // namespace

Law tuned_by_hand(double speed) {
  std::vector<double> gains(kGains);
  gains[0] = speed;
  gains[1] = 0.1;  // ramp [s]
  gains[2] = 1e3;  // no end depth
  gains[3] = 1;
  gains[4] = 0.25;  // slowing [1/N^2]
  gains[6] = gains[7] = 1e-3;
  return {LawKind::insertion, gains};
}

const std::vector<Learner>& learners() {
  static const std::vector<Learner> all = {law_learner(), policy_learner(), search_learner()};
  return all;
}

std::vector<Candidate> baselines(const Scene& scene, const DemonstrationSet& set,
                                 const OperatorSkill& skill, std::uint64_t seed) {
  const double speed = scene_scaling(scene).motion * scene.limits.speed;
  return {{"constant velocity", controller_maker(ConstantVelocity(speed))},
          {"tuned by hand", controller_maker(tuned_by_hand(speed))},
          {"best demonstration again", controller_maker(RecordedMotion(fastest(set)))},
          {"simulated operator", simulated_operators(scene, skill, seed)}};
}

ControllerFile learned(const Learner& learner, const Learner::Variant& variant,
                       const DemonstrationSet& set, std::uint64_t seed,
                       const LearnerProgress& progress) {
  LearnerSettings settings{seed, variant.options};
  for (const LearnerOption& option : learner.options)
    settings.options.emplace(option.flag, option.value);  // where the variant has none
  return learner.learn(set, settings, progress).controller;
}

Candidate candidate(const std::string& name, const ControllerFile& learned, double seconds) {
  return std::visit(
      [&](const auto& c) -> Candidate {
        return {.name = name,
                .make = c.maker(),
                .parameters = c.parameters(),
                .fit_seconds = seconds,
                .held_out = c.held_out_residual,
                .rollouts = c.trained_on.rollouts,
                .file = learned};
      },
      learned);
}

DemonstrationSet first_of(const DemonstrationSet& set, std::size_t count) {
  DemonstrationSet part = set;
  if (count < part.demonstrations.size())
    part.demonstrations.erase(part.demonstrations.begin() + static_cast<std::ptrdiff_t>(count),
                              part.demonstrations.end());
  return part;
}

double ns_per_action(const Candidate& candidate, const Demonstration& demonstration) {
  const std::unique_ptr<Controller> controller = candidate.make(1);
  Eigen::Index n = 0;
  return nanoseconds_per_call([&](long) {
    for (std::uint64_t period = 0; period < candidate.periods; ++period) {
      n = n + 1 < demonstration.rows() ? n + 1 : 0;
      keep(controller->command(demonstration.observed(n)));
    }
  });
}

}  // namespace ferrule
