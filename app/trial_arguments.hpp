// Options of whatever runs trials: --seed, --seeds, --skill and --threads.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

#include "insertion/operator_skill.hpp"

namespace ferrule {

// A whole number from 0 to 2^63 - 1, the rule of every seed.
CLI::Validator seed_rule();
// --seed, or another flag: a whole number from 0 to 2^63 - 1.
void add_seed(CLI::App& verb, std::uint64_t& seed, const std::string& help,
              const char* flag = "--seed");
// --skill of a simulated operator (insertion/operator_skill.hpp).
CLI::Option* add_skill(CLI::App& verb, OperatorSkill& skill, const std::string& help);
// --seeds: "1..5" or "1,2,7".
void add_seeds(CLI::App& verb, std::string& seeds, const std::string& help);
// Throws BadInput.
std::vector<std::uint64_t> parse_seeds(const std::string& text);

// --threads of a campaign. 0: all cores.
void add_threads(CLI::App& verb, int& threads);

}  // namespace ferrule
