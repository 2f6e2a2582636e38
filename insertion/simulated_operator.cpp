#include "insertion/simulated_operator.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "insertion/scene_scaling.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

constexpr double kPress = 0.6;  // 0.7 uN at the tip with the paper's scaling [N]

constexpr std::string_view kSkill = ", skill ";

}  // namespace

TraineeTask trainee_task(const Scene& scene, const State& start, double period, std::uint64_t seed,
                         std::uint64_t trial) noexcept {
  const Scaling scaling = scene_scaling(scene);
  const double distance =
      scene.start.distance - scene.sensor.entrance_error + scene.success.depth + overshoot(scene);
  TraineeTask task = {scaling.motion_to_hand(start.command),
                      scaling.motion * distance,
                      scaling.motion * scene.limits.speed,
                      kPress,
                      period,
                      {}};
  if (scene.start.vision_sd && scene.start.distance > 0) {
    RandomStream random(seed, trial, Draw::operator_eye);
    const double y = random.normal(), z = random.normal();
    const Vector2d seen = *scene.start.vision_sd * Vector2d(y, z);
    task.aim = {
        scaling.motion * scene.start.distance,
        task.start.segment<2>(1) + scaling.motion * (seen - Vector2d(start.tip.segment<2>(1)))};
  }
  return task;
}

std::unique_ptr<Device> simulated_operator(const Scene& scene, const State& start, double skill,
                                           double period, std::uint64_t seed, std::uint64_t trial) {
  return std::make_unique<Trainee>(
      trainee_traits(skill), trainee_task(scene, start, period, seed, trial),
      [random = RandomStream(seed, trial, Draw::operator_hand)]() mutable {
        return random.uniform();
      });
}

std::unique_ptr<Device> operator_of_trial(const Scene& toleranced, double skill, double period,
                                          std::uint64_t seed, std::uint64_t trial) {
  const auto drawn = draw_scene(toleranced, seed, trial);
  const Scene& scene = drawn ? *drawn : toleranced;
  return simulated_operator(scene, draw_start(scene, seed, trial), skill, period, seed, trial);
}

std::string simulated_operator_name(double skill) {
  return operator_name("simulated", skill);
}
std::optional<double> simulated_skill(const std::string& name) {
  return skill_of("simulated", name);
}

std::string operator_name(const std::string& who, double skill) {
  return fmt::format("{}{}{}", who, kSkill, skill);
}

std::optional<double> skill_of(const std::string& who, const std::string& name) {
  const std::string head = who + std::string(kSkill);
  if (!name.starts_with(head)) return std::nullopt;
  const char* const end = name.data() + name.size();
  double skill = -1;
  const auto read = std::from_chars(name.data() + head.size(), end, skill);
  if (read.ec != std::errc() || read.ptr != end || !(skill >= 0 && skill <= 1)) return std::nullopt;
  return skill;
}

}  // namespace ferrule
