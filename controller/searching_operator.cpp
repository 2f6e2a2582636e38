#include "controller/searching_operator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "controller/controller_file.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/base/control_period.hpp"
#include "sim/base/random.hpp"

namespace ferrule {
namespace {

constexpr std::array<std::string_view, 4> kHisTraits = {"delay", "peak_speed", "tremor",
                                                        "hesitation_rate"};

// The gains of a law whose speeds are `part` of these.
std::vector<double> slowed(std::vector<double> gains, double part) {
  for (std::size_t i = 0; i < gains.size(); ++i)
    if (std::string_view(kSearchGains[i].name).ends_with("_speed")) gains[i] *= part;
  return gains;
}

// What he knows in a scene.
struct Known {
  std::vector<double> gains;
  double stiffness;  // [N/m]
};

Known known_in(const Scene& scene) {
  const auto search = std::get<SearchFile>(read_controller("search"));
  const Scaling scaling = scene_scaling(scene);
  const Scaling its = search.trained_on.scaling.value();
  if (differ(its, scaling))
    throw BadInput(
        fmt::format("the operator who searches is one for the scaling of bench (motion x{:.6g}, "
                    "force x{:.6g}), "
                    "not of {} (x{:.6g}, x{:.6g})",
                    its.motion, its.force, scene.name, scaling.motion, scaling.force));
  return {search.gains, scene.world.holder.stiffness(0, 0) * scaling.force / scaling.motion};
}

}  // namespace

SearchingOperator::SearchingOperator(const TraineeTraits& traits, std::vector<double> gains,
                                     double stiffness, double period,
                                     std::function<double()> uniform)
    : period_(period),
      hand_(traits.tremor, traits.hesitation_rate, period, std::move(uniform)),
      law_(slowed(std::move(gains), traits.peak_speed), ferrule_own_hand{traits.delay, stiffness}),
      observed_(static_cast<std::size_t>(std::lround(traits.delay / period))) {}

HandTwist SearchingOperator::command(const Observation& observation) noexcept {
  Observation& oldest = observed_[next_];
  const Observation felt = oldest;
  oldest = observation;
  oldest.time = law_time_;
  next_ = (next_ + 1) % observed_.size();
  const double drive = hand_.drive(observation.time);
  law_time_ += drive * period_;
  HandTwist velocity = HandTwist::Zero();
  if (seen_ < observed_.size())
    ++seen_;
  else
    velocity = drive * law_.command(felt);
  velocity.head<3>() += hand_.tremor_velocity(observation.time);
  return velocity;
}

MakeController searching_operator(const Scene& scene, const OperatorSkill& skill,
                                  std::uint64_t seed) {
  for (const std::string& trait : skill.own())
    if (std::find(kHisTraits.begin(), kHisTraits.end(), trait) == kHisTraits.end())
      throw BadInput(fmt::format("skill {}: the operator who searches has no {}; he has {}",
                                 skill.text(), trait, fmt::join(kHisTraits, ", ")));
  return [known = known_in(scene), traits = skill.traits(), seed](std::uint64_t trial) {
    return std::make_unique<SearchingOperator>(
        traits, known.gains, known.stiffness, kControlPeriod,
        [random = RandomStream(seed, trial, Draw::operator_hand)]() mutable {
          return random.uniform();
        });
  };
}

std::unique_ptr<Controller> searching_operator(const Scene& scene, const TraineeTraits& traits,
                                               double period, std::function<double()> uniform) {
  const Known known = known_in(scene);
  return std::make_unique<SearchingOperator>(traits, known.gains, known.stiffness, period,
                                             std::move(uniform));
}

}  // namespace ferrule
