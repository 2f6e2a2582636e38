// What differs between a recording and the same computed again.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "sim/base/json_fields.hpp"

namespace ferrule {

// A number or a text that is not what it should be.
struct Difference {
  std::size_t row = 0;      // where there are rows
  std::string column;       // block or data set and the index in it; an attribute; "outcome"
  Json recorded, expected;  // null: not there
  // |recorded - expected| over the largest number of that unit there; infinite without numbers [-]
  double relative = INFINITY;
};

struct Verification {
  // Numbers may differ by this much [-], as `Difference::relative`. 0: every bit is compared, up to
  // the first difference.
  double tolerance = 0;
  std::optional<Difference> first;    // beyond the tolerance
  std::optional<Difference> largest;  // of numbers

  bool over() const noexcept { return first && tolerance == 0; }
  void add(Difference found) {
    if (std::isfinite(found.relative) && (!largest || found.relative > largest->relative))
      largest = found;
    if (!first && (tolerance == 0 || !(found.relative <= tolerance))) first = std::move(found);
  }
};

// Of the numbers of each unit, the largest; for each column. `units` has one word per column, or is
// for all of them.
Eigen::RowVectorXd largest_by_unit(const Eigen::Ref<const Eigen::MatrixXd>& values,
                                   const std::string& units);

// Adds what of a row differs by a single bit or more, until the comparison is over. `scale(c)` is
// the largest number of the unit of column c, `column(c)` its name.
template <class Scale, class Column>
void compare_numbers(const Eigen::Ref<const Eigen::RowVectorXd>& recorded,
                     const Eigen::Ref<const Eigen::RowVectorXd>& expected, const Scale& scale,
                     std::size_t row, const Column& column, Verification& comparison) {
  for (Eigen::Index c = 0; c < recorded.size() && !comparison.over(); ++c) {
    const double a = recorded[c], b = expected[c], difference = std::abs(a - b);
    if (std::bit_cast<std::uint64_t>(a) != std::bit_cast<std::uint64_t>(b))
      comparison.add({row, column(c), a, b, difference == 0 ? 0 : difference / scale(c)});
  }
}

}  // namespace ferrule
