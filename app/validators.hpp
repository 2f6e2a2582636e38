// What the value of an option may be: one of some texts, a number within bounds, a range of numbers.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace ferrule {

// One of these texts; of another one it names the nearest.
CLI::Validator one_of(const std::vector<std::string>& choices);
// A whole number within bounds, in decimal.
CLI::Validator whole_number(std::uint64_t low, std::uint64_t high);
// A finite number within bounds, in decimal.
CLI::Validator number_between(double low, double high);

// "10", "1:500:50" (from:to:count, both ends in), "1:500:50:log". Throws BadInput naming `option`.
std::vector<double> parse_range(const std::string& text, const std::string& option);

// That part of the way, 0 to 1, between two ends; `logarithmic`: in equal ratios, both ends > 0.
double interpolate(double from, double to, double part, bool logarithmic);

}  // namespace ferrule
