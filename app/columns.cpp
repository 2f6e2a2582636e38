#include "app/columns.hpp"

#include <cmath>
#include <string_view>

namespace ferrule {

std::string aligned(const char* format, const Json& cell, const char* not_finite) {
  const std::string_view all = format;
  const auto as = [&](std::string_view presentation, const auto& value) {
    return fmt::format(fmt::runtime(fmt::format("{{:{}}}", presentation)), value);
  };
  const std::string_view alignment = all.substr(0, all.find_first_not_of("<>0123456789"));
  if (cell.is_number_float() && std::isfinite(cell.get<double>()))
    return as(all, cell.get<double>());
  if (cell.is_number_integer()) return as(alignment, cell.get<long long>());
  return as(alignment, cell.is_string() ? cell.get<std::string>() : std::string(not_finite));
}

}  // namespace ferrule
