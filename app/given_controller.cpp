#include "app/given_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "controller/blind_spiral.hpp"
#include "controller/held_controller.hpp"
#include "controller/program_policy.hpp"
#include "controller/searching_operator.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/torch_policy.hpp"
#include "sim/base/error.hpp"

namespace ferrule {

void PolicyArguments::add_to(CLI::App& verb) {
  verb.add_option("--policy", command,
                  "A program that answers observations, a line of JSON each (controller/README.md)")
      ->type_name("COMMAND");
  verb.add_option("--policy-hz", hz, "How many times a second it, or TorchScript, is asked")
      ->capture_default_str()
      ->check(number_between(1, 1000));
  verb.add_option("--policy-timeout", timeout,
                  "Longest time for one answer of either [s]; six times that at a reset")
      ->capture_default_str()
      ->check(number_between(1e-3, 3600));
}

std::uint64_t PolicyArguments::periods() const {
  const double periods = 1000 / hz;
  if (std::abs(periods - std::round(periods)) > 1e-9 * periods)
    throw BadInput(fmt::format("--policy-hz {:g}: 1000 must be a whole multiple of it", hz));
  return static_cast<std::uint64_t>(std::lround(periods));
}

namespace {

// How it is asked in trials under `seed`; what it says goes to stderr.
ProgramSettings settings(const PolicyArguments& how, std::uint64_t seed) {
  return {.start_timeout = 6 * how.timeout,
          .timeout = how.timeout,
          .control_hz = how.hz,
          .seed = seed,
          .stop = interrupted,
          .said = [](const std::string& text) { fmt::print(stderr, "{}", text); }};
}

}  // namespace

GivenController given_file(const std::string& file, const PolicyArguments& how,
                           std::uint64_t seed) {
  if (file.ends_with(".pt"))
    return {
        file, held(load_torchscript(file, settings(how, seed)), how.periods()), {}, how.periods()};
  ControllerFile read = read_controller(file);
  MakeController make = maker(read);
  return {file, std::move(make), std::move(read)};
}

bool is_baseline(const std::string& name) {
  return name == kStraight || name == kSpiral || name == kSearching;
}

MakeController baseline(const std::string& name, const Scene& scene, std::uint64_t seed) {
  if (name == kSearching) return searching_operator(scene, 0.8, seed);
  const Scaling scaling = scene_scaling(scene);
  const double speed = scaling.motion * scene.limits.speed;
  if (name == kStraight) return controller_maker(ConstantVelocity(speed));
  return controller_maker(
      BlindSpiral(speed, scaling.force * scene.limits.force / 12,
                  std::numbers::sqrt2 * scaling.motion * scene.world.annulus.clearance()));
}

GivenController given_program(const PolicyArguments& how, std::uint64_t seed) {
  const MakeController make = program_policy(how.command, settings(how, seed));
  return {how.command, held(make, how.periods()), {}, how.periods()};
}

std::map<std::string, std::size_t> failures(const std::vector<TrialResult>& results) {
  std::map<std::string, std::size_t> reasons;
  for (const TrialResult& r : results)
    if (!r.why.empty()) ++reasons[printable(r.why, 300)];
  return reasons;
}

void add_failures(const std::vector<TrialResult>& results, const Output& output, Json& row) {
  const auto found = failures(results);
  std::string text;
  for (const auto& [why, count] : found)
    text += fmt::format("{}{} of {}: {}", text.empty() ? "" : "; ", count, results.size(), why);
  if (output.csv)
    row["failures"] = text;
  else if (!found.empty())
    row["failures"] = found;
}

void tell_failures(const std::string& name, const std::vector<TrialResult>& results) {
  for (const auto& [why, count] : failures(results))
    fmt::print(stderr, "note: {}: {} of {} trials: {}\n", name, count, results.size(), why);
}

void refuse_if_all_failed(const std::string& name, const std::vector<TrialResult>& results) {
  const auto failed = [](const TrialResult& r) {
    return r.outcome == Outcome::infeasible || !r.why.empty();
  };
  const auto reasons = failures(results);
  if (reasons.empty() || !std::all_of(results.begin(), results.end(), failed)) return;
  const auto most =
      std::max_element(reasons.begin(), reasons.end(),
                       [](const auto& a, const auto& b) { return a.second < b.second; });
  throw BadInput(
      fmt::format("{}: failed in each of {} trials: {}", name, results.size(), most->first));
}

}  // namespace ferrule
