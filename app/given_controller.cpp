#include "app/given_controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/interrupt.hpp"
#include "app/validators.hpp"
#include "controller/held_controller.hpp"
#include "controller/program_policy.hpp"
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

GivenController given_controller(const std::string& name, const PolicyArguments& how,
                                 std::uint64_t seed) {
  if (is_baseline(name))
    return {name, [name, seed](const Scene& scene) { return baseline(name, scene, seed); }, {}};
  const auto anywhere = [](MakeController make) {
    return [make = std::move(make)](const Scene&) { return make; };
  };
  if (name.ends_with(".pt"))
    return {name,
            anywhere(held(load_torchscript(name, settings(how, seed)), how.periods())),
            {},
            how.periods(),
            name};
  ControllerFile file = read_controller(name);
  MakeController make = maker(file);
  return {name, anywhere(std::move(make)), std::move(file), 1, controller_file(name)};
}

ControllerFile own_controller(const std::string& name, const std::string& why) {
  if (is_baseline(name) || name.ends_with(".pt")) throw BadInput(name + ": " + why);
  return read_controller(name);
}

GivenController given_program(const PolicyArguments& how, std::uint64_t seed) {
  MakeController make = held(program_policy(how.command, settings(how, seed)), how.periods());
  return {how.command, [make](const Scene&) { return make; }, {}, how.periods()};
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
