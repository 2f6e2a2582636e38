#include "app/trial_arguments.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "app/validators.hpp"
#include "sim/base/error.hpp"

namespace ferrule {
namespace {

bool is_seed(const std::string& text) {
  const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
  return digits && (text.size() < 19 || (text.size() == 19 && text <= "9223372036854775807"));
}

}  // namespace

CLI::Validator seed_rule() {
  return CLI::Validator(
      [](const std::string& text) {
        return is_seed(text) ? std::string()
                             : "must be a whole number from 0 to 2^63 - 1, not " + text;
      },
      "WHOLE");
}

void add_seed(CLI::App& verb, std::uint64_t& seed, const std::string& help, const char* flag) {
  verb.add_option(flag, seed, help)->capture_default_str()->check(seed_rule());
}

CLI::Option* add_skill(CLI::App& verb, OperatorSkill& skill, const std::string& help) {
  const auto read = [&skill](const std::string& text) {
    try {
      skill = OperatorSkill::parse(text);
    } catch (const BadInput& error) {
      throw CLI::ValidationError("--skill", error.what());
    }
  };
  return verb.add_option_function<std::string>("--skill", read, help)
      ->default_str(skill.text())
      ->type_name("0 to 1[,TRAIT=VALUE,...]");
}

void add_seeds(CLI::App& verb, std::string& seeds, const std::string& help) {
  verb.add_option("--seeds", seeds, help)->type_name("FROM..TO|N,N,...");
}

std::vector<std::uint64_t> parse_seeds(const std::string& text) {
  constexpr std::uint64_t kMost = 1000;
  const auto refuse = [&]() {
    return BadInput("--seeds " + text +
                    ": must be FROM..TO or N,N,..., up to 1000 whole numbers from 0 to 2^63 - 1");
  };
  std::vector<std::uint64_t> seeds;
  if (const auto dots = text.find(".."); dots != text.npos) {
    const std::string from = text.substr(0, dots), to = text.substr(dots + 2);
    if (!is_seed(from) || !is_seed(to)) throw refuse();
    const std::uint64_t first = std::stoull(from), last = std::stoull(to);
    if (last < first || last - first >= kMost) throw refuse();
    for (std::uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
    return seeds;
  }
  for (const std::string& part : CLI::detail::split(text, ',')) {
    if (!is_seed(part) || seeds.size() == kMost) throw refuse();
    seeds.push_back(std::stoull(part));
  }
  return seeds;
}

void add_threads(CLI::App& verb, int& threads) {
  constexpr std::uint64_t kMostThreads = 4096;
  const std::uint64_t cores = std::max(1u, std::thread::hardware_concurrency());
  const auto at_most_cores = [cores](std::string& text) {
    if (whole_number(cores + 1, kMostThreads)(text).empty()) {
      fmt::print(stderr, "note: --threads {}: this machine has {}, which are used\n",
                 std::stoull(text), cores);
      text = std::to_string(cores);
    }
    return std::string();
  };
  verb.add_option("--threads", threads, "0: all cores; the result does not depend on it")
      ->capture_default_str()
      ->transform(CLI::Validator(at_most_cores, ""))
      ->check(whole_number(0, kMostThreads));
}

}  // namespace ferrule
