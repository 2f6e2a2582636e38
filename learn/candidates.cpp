#include "learn/candidates.hpp"

#include <algorithm>

#include "bench/measure.hpp"
#include "controller/device_controller.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "learn/fit_law.hpp"
#include "learn/fit_policy.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

// A recorded hand motion again, whatever is felt.
class RecordedMotion : public Controller {
 public:
  explicit RecordedMotion(std::shared_ptr<const Demonstration> recorded)
      : recorded_(std::move(recorded)) {}

  HandTwist command(const Observation&) noexcept override {
    HandTwist v = HandTwist::Zero();
    if (next_ < recorded_->velocity.rows())
      v.head<3>() = recorded_->velocity.row(next_++).transpose();
    return v;
  }

 private:
  std::shared_ptr<const Demonstration> recorded_;
  Eigen::Index next_ = 0;
};

// What an engineer sets without demonstrations: straight in at the speed limit, at half of it where
// 2 N are felt, and sideways as compliant as a hand, 1 mm/s per newton.
InsertionLaw tuned_by_hand(double speed) {
  std::array<double, kGains> gains{};
  gains[0] = speed;
  gains[1] = 0.1;  // ramp [s]
  gains[2] = 1e3;  // no end depth
  gains[3] = 1;
  gains[4] = 0.25;  // slowing [1/N^2]
  gains[6] = gains[7] = 1e-3;
  return InsertionLaw(gains);
}

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

std::vector<Contestant> unlearned(const Scene& scene, const DemonstrationSet& set, double skill,
                                  std::uint64_t seed) {
  const Scaling scaling = scene_scaling(scene);
  const double speed = scaling.motion * scene.limits.speed;
  const auto duration = [](const Demonstration& d) {
    return d.period * static_cast<double>(d.velocity.rows());
  };
  const auto fastest = std::make_shared<const Demonstration>(
      *std::min_element(set.demonstrations.begin(), set.demonstrations.end(),
                        [&](const auto& a, const auto& b) { return duration(a) < duration(b); }));
  std::vector<Contestant> all;
  all.push_back({"constant velocity", controller_maker(ConstantVelocity(speed)), 0, 0, {}});
  all.push_back({"tuned by hand", controller_maker(tuned_by_hand(speed)), 0, 0, {}});
  all.push_back({"best demonstration again",
                 [fastest](std::uint64_t) { return std::make_unique<RecordedMotion>(fastest); },
                 0,
                 0,
                 {}});
  all.push_back({"simulated operator",
                 [&scene, skill, seed](std::uint64_t trial) -> std::unique_ptr<Controller> {
                   constexpr double kPeriod = 1e-3;
                   const State start = draw_start(scene, seed, trial);
                   return std::make_unique<DeviceController>(
                       simulated_operator(scene, start, skill, kPeriod, seed, trial), kPeriod);
                 },
                 0,
                 0,
                 {}});
  return all;
}

std::vector<Learner> learners(std::uint64_t fit_seed) {
  std::vector<Learner> all;
  for (const LawKind kind : kLaws)
    all.push_back(
        {name(kind), std::string("ceres, ") + name(kind), [=](const DemonstrationSet& set) {
           Contestant c;
           FitReport report;
           c.fit_seconds = seconds_of([&] { report = fit_law(set, fit_seed, kind); });
           c.make = controller_maker(report.controller.law());
           c.parameters = gain_table(kind).size();
           c.held_out = report.controller.held_out_residual;
           return c;
         }});
  const auto torch = [&](const char* key, const char* name, std::size_t members,
                         std::size_t rounds) {
    all.push_back({key, name, [=](const DemonstrationSet& set) {
                     PolicySettings settings;
                     settings.members = members;
                     settings.dagger_rounds = rounds;
                     settings.seed = fit_seed;
                     Contestant c;
                     PolicyFit fit;
                     c.fit_seconds = seconds_of([&] {
                       fit = fit_policy(set, settings, [](std::size_t, const Epoch&) {});
                     });
                     c.make = controller_maker(PolicyController(fit.file.policy));
                     for (const Network& network : fit.file.policy.members)
                       for (const Layer& layer : network)
                         c.parameters +=
                             static_cast<std::size_t>(layer.weight.size() + layer.bias.size());
                     c.held_out = fit.file.held_out_residual;
                     return c;
                   }});
  };
  torch("torch", "torch", 1, 0);
  torch("ensemble", "torch, ensemble of 5", 5, 0);
  torch("dagger", "torch, DAgger 3 rounds", 1, 3);
  return all;
}

DemonstrationSet first_of(const DemonstrationSet& set, std::size_t count) {
  DemonstrationSet part = set;
  if (count < part.demonstrations.size())
    part.demonstrations.erase(part.demonstrations.begin() + static_cast<std::ptrdiff_t>(count),
                              part.demonstrations.end());
  return part;
}

double ns_per_action(const Contestant& contestant, const Demonstration& felt) {
  const std::unique_ptr<Controller> controller = contestant.make(1);
  const auto rows = felt.force.rows();
  Felt now{HandWrench::Zero(), 0, 0};
  Eigen::Index n = 0;
  return nanoseconds_per_call([&](long) {
    n = n + 1 < rows ? n + 1 : 0;
    now.wrench.head<3>() = felt.force.row(n).transpose();
    now.depth = felt.depth[n];
    now.time = felt.time[n];
    keep(controller->command(now));
  });
}

}  // namespace ferrule
