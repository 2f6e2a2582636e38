#include "insertion/operator_skill.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "sim/base/error.hpp"
#include "sim/base/unknown_name.hpp"

namespace ferrule {
namespace {

const std::string kSimulated = "simulated, skill ", kSearching = "searching, skill ";

// Throws BadInput where it is no number from `low` to `high`.
double number(std::string_view text, const std::string& what, double low, double high) {
  double value = NAN;
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !(value >= low && value <= high))
    throw BadInput(fmt::format("{} = {}: must be a number from {} to {}", what, text, low, high));
  return value;
}

const Trait& trait(const std::string& name) {
  const auto at =
      std::find_if(kTraits.begin(), kTraits.end(), [&](const Trait& t) { return t.name == name; });
  if (at != kTraits.end()) return *at;
  std::vector<std::string> names;
  for (const Trait& t : kTraits) names.push_back(t.name);
  throw BadInput(fmt::format("a simulated operator has no trait \"{}\"{}; he has {}", name,
                             did_you_mean(name, names), fmt::join(names, ", ")));
}

}  // namespace

OperatorSkill::OperatorSkill(double skill)
    : traits_(trainee_traits(skill)), text_(fmt::format("{}", skill)) {}

OperatorSkill OperatorSkill::parse(const std::string& text) {
  const auto part = [&](std::size_t from) {
    return std::string_view(text).substr(from, text.find(',', from) - from);
  };
  OperatorSkill skill(number(part(0), "skill", 0, 1));
  for (std::size_t at = text.find(','); at != text.npos; at = text.find(',', at + 1)) {
    const std::string_view setting = part(at + 1);
    const std::size_t sign = setting.find('=');
    if (sign == setting.npos)
      throw BadInput(fmt::format("skill {}: must be a number and traits: 0.8,TRAIT=VALUE", text));
    const Trait& t = trait(std::string(setting.substr(0, sign)));
    if (std::find(skill.own_.begin(), skill.own_.end(), t.name) != skill.own_.end())
      throw BadInput(fmt::format("skill {}: {} stands there twice", text, t.name));
    skill.traits_.*t.value = number(setting.substr(sign + 1), t.name, t.low, t.high);
    skill.own_.push_back(t.name);
    skill.text_ += fmt::format(",{}={}", t.name, skill.traits_.*t.value);
  }
  return skill;
}

std::string SimulatedOperator::name() const {
  return (searches ? kSearching : kSimulated) + skill.text();
}

std::optional<SimulatedOperator> SimulatedOperator::named(const std::string& name) {
  const bool searches = name.starts_with(kSearching);
  const std::string& head = searches ? kSearching : kSimulated;
  if (!name.starts_with(head)) return std::nullopt;
  try {
    return SimulatedOperator{OperatorSkill::parse(name.substr(head.size())), searches};
  } catch (const BadInput&) {
    return std::nullopt;
  }
}

}  // namespace ferrule
