#include "learn/ablation.hpp"

#include "learn/record_again.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/scene_keys.hpp"

namespace ferrule {
namespace {

class Ablated : public ControllerWrapper {
 public:
  Ablated(std::unique_ptr<Controller> inner, Ablation what)
      : ControllerWrapper(std::move(inner)), what_(what) {}
  HandTwist command(const Observation& observation) noexcept override {
    Observation left = observation;
    if (what_ == Ablation::force) left.wrench.setZero();
    if (what_ == Ablation::memory) left.displacement.setZero();
    HandTwist velocity = inner_->command(left);
    if (what_ == Ablation::tilt) velocity.tail<2>().setZero();
    return velocity;
  }

 private:
  Ablation what_;
};

// The scene in which all trials are alike, but for what operator and sensor add.
Json unvaried(const Json& document, std::uint64_t seed) {
  const std::string what = "the scene of the episodes";
  const Scene scene = parse_scene(document, what);
  Json same = feasible_trial(scene, seed, 1).scene->document();
  Json& start = same["start"];
  start["lateral_sd_um"] = start["tilt_sd_mrad"] = 0;
  for (const SceneKey& key : scene_keys())
    if (const std::string name = key.name; key.chance.may_add() && name.starts_with("start."))
      start.erase(name.substr(name.find('.') + 1));
  return same;
}

}  // namespace

bool has(const ControllerFile& controller, Ablation what) {
  if (what == Ablation::variation) return false;
  if (what == Ablation::force || std::holds_alternative<SearchFile>(controller)) return true;
  const auto* network = std::get_if<PolicyFile>(&controller);
  if (!network) return false;
  if (what == Ablation::memory) return !network->policy.memories.empty();
  return network->policy.answers() == kTwist;
}

MakeController without(Ablation what, const MakeController& make) {
  return [what, make](std::uint64_t trial) { return std::make_unique<Ablated>(make(trial), what); };
}

DemonstrationSet without(Ablation what, const DemonstrationSet& set, std::uint64_t seed,
                         const std::function<void()>& go_on) {
  DemonstrationSet left = set;
  if (what == Ablation::variation) {
    expect_recordable_again(set);
    left.undrawn_documents = {unvaried(set.undrawn_documents.front(), seed)};
    return record_again(left, seed, go_on);
  }
  for (Demonstration& d : left.demonstrations) {
    for (Observation& o : d.observations) {
      if (what == Ablation::force) o.wrench.setZero();
      if (what == Ablation::memory) o.displacement.setZero();
    }
    if (what == Ablation::tilt) d.tilt_rates.setZero();
  }
  return left;
}

std::optional<Learner::Variant> without(Ablation what, const Learner& learner,
                                        const Learner::Variant& variant) {
  if (learner.memoryless.empty()) return {};
  Learner::Variant left = variant;
  if (what == Ablation::memory)
    for (const auto& [flag, value] : learner.memoryless) left.options[flag] = value;
  return left;
}

}  // namespace ferrule
