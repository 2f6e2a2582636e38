// How chance decides a number of a scene: what stands in its file in the number's place.
//
//   {"normal": [mean, sd]}           cut at three standard deviations, where sorting ends
//   {"uniform": [low, high]}
//   {"lognormal": [median, spread]}  e^x with x normal about ln(median), spread its standard
//                                    deviation, cut at three of them; median > 0
//   {"choice": [a, b, ...]}          one of these, all as likely
//
// All in the unit of the key.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/base/json_fields.hpp"
#include "sim/base/random.hpp"

namespace ferrule {

class Distribution {
 public:
  // Normal, of which `sd` >= 0 is the standard deviation; uniform, low <= high.
  static Distribution about(double mean, double sd) { return {normal, {mean, sd}}; }
  static Distribution between(double low, double high) { return {uniform, {low, high}}; }

  // Empty: `value` is not a distribution. Throws BadInput: what it must be.
  static std::optional<Distribution> read(const Json& value);

  double draw(RandomStream& random) const noexcept;
  // Where a scene is taken as it is without chance: mean, middle or median; the first of a choice.
  double centre() const noexcept;
  // The least and the most that can be drawn; of a choice all of it.
  std::vector<double> extremes() const;

 private:
  enum Kind { normal, uniform, lognormal, choice };

  Distribution(Kind kind, std::vector<double> numbers)
      : kind_(kind), numbers_(std::move(numbers)) {}

  Kind kind_;
  std::vector<double> numbers_;
};

// A number as a file has it: 126 rather than 126.0.
Json as_written(double x);

// "126+-0.3" is normal and cut at 0.3; "125.5+1/-0" and "125.2..126.5" are uniform. Empty: neither.
std::optional<Json> distribution_of(std::string text);

}  // namespace ferrule
