#include "app/validators.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "sim/base/elementary.hpp"
#include "sim/base/error.hpp"
#include "sim/base/unknown_name.hpp"

namespace ferrule {
namespace {

// What `text` is in decimal, and nothing else; empty: no such number.
template <class Number>
std::optional<Number> decimal(std::string_view text) {
  Number value{};
  if (text.starts_with('+')) text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && rest == end ? std::optional(value) : std::nullopt;
}

// CLI11 would read 010 as 8, and 0x10 as 16.
std::optional<std::uint64_t> whole(std::string_view text) {
  const bool octal = text.size() > 1 && text[0] == '0';
  return octal ? std::nullopt : decimal<std::uint64_t>(text);
}

double parse_number(const std::string& text, const std::string& option) {
  const double value = decimal<double>(text).value_or(NAN);
  if (!std::isfinite(value))
    throw BadInput(option + " " + text + ": must be a number or from:to:count[:log]");
  return value;
}

}  // namespace

CLI::Validator one_of(const std::vector<std::string>& choices) {
  const std::string all = CLI::detail::generate_set(choices);
  return CLI::Validator(
      [choices, all](const std::string& text) {
        const bool known = std::find(choices.begin(), choices.end(), text) != choices.end();
        return known ? std::string() : text + " not in " + all + did_you_mean(text, choices);
      },
      all);
}

CLI::Validator whole_number(std::uint64_t low, std::uint64_t high) {
  const auto inside = [low, high](const std::string& text) {
    const std::optional<std::uint64_t> value = whole(text);
    return value && *value >= low && *value <= high
               ? std::string()
               : fmt::format("must be a whole number from {} to {}, not {}", low, high, text);
  };
  return CLI::Validator(inside, fmt::format("[{} to {}]", low, high));
}

CLI::Validator number_between(double low, double high) {
  const auto inside = [low, high](const std::string& text) {
    const double value = decimal<double>(text).value_or(NAN);
    return value >= low && value <= high
               ? std::string()
               : fmt::format("must be a number from {} to {}, not {}", low, high, text);
  };
  return CLI::Validator(inside, fmt::format("[{} to {}]", low, high));
}

std::vector<double> parse_range(const std::string& text, const std::string& option) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  if (parts.size() == 1) return {parse_number(parts[0], option)};
  if (parts.size() < 3 || parts.size() > 4 || (parts.size() == 4 && parts[3] != "log"))
    throw BadInput(option + " " + text + ": must be a number or from:to:count[:log]");
  const double from = parse_number(parts[0], option), to = parse_number(parts[1], option);
  const double count = parse_number(parts[2], option);
  if (count != std::floor(count) || count < 1 || count > 1e6)
    throw BadInput(option + " " + text + ": the count must be a whole number from 1 to 1000000");
  const bool logarithmic = parts.size() == 4;
  if (logarithmic && !(from > 0 && to > 0))
    throw BadInput(option + " " + text + ": both ends of a logarithmic range must be positive");
  if (logarithmic && !(std::isfinite(to / from) && to / from > 0))
    throw BadInput(option + " " + text + ": the ends are too far apart");
  const auto n = static_cast<std::size_t>(count);
  std::vector<double> values(n, from);
  for (std::size_t i = 1; i < n; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(n - 1);
    values[i] = interpolate(from, to, part, logarithmic);
  }
  if (n > 1) values.back() = to;
  return values;
}

double interpolate(double from, double to, double part, bool logarithmic) {
  return logarithmic ? from * elementary::exp(part * elementary::log(to / from))
                     : from + part * (to - from);
}

}  // namespace ferrule
