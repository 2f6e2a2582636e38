#include "sim/base/unknown_name.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <sstream>

namespace ferrule {
namespace {

std::size_t levenshtein(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0]++;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t exchanged = diagonal + (a[i] != b[j]);
      diagonal = row[j + 1];
      row[j + 1] = std::min({exchanged, row[j] + 1, diagonal + 1});
    }
  }
  return row.back();
}

struct Unit {
  const char* name;
  char dimension;
  double si;
};
constexpr Unit kUnits[] = {{"m", 'L', 1},       {"cm", 'L', 1e-2},
                           {"mm", 'L', 1e-3},   {"um", 'L', 1e-6},
                           {"nm", 'L', 1e-9},   {"N", 'F', 1},
                           {"mN", 'F', 1e-3},   {"uN", 'F', 1e-6},
                           {"nN", 'F', 1e-9},   {"s", 'T', 1},
                           {"ms", 'T', 1e-3},   {"us", 'T', 1e-6},
                           {"Hz", 'f', 1},      {"kHz", 'f', 1e3},
                           {"Pa", 'p', 1},      {"kPa", 'p', 1e3},
                           {"MPa", 'p', 1e6},   {"GPa", 'p', 1e9},
                           {"mPa", 'p', 1e-3},  {"V", 'V', 1},
                           {"mV", 'V', 1e-3},   {"kV", 'V', 1e3},
                           {"kg", 'M', 1},      {"g", 'M', 1e-3},
                           {"rad", 'a', 1},     {"mrad", 'a', 1e-3},
                           {"urad", 'a', 1e-6}, {"deg", 'a', std::numbers::pi / 180}};

const Unit* unit(const std::string& name) {
  const auto found = std::find_if(std::begin(kUnits), std::end(kUnits),
                                  [&](const Unit& u) { return name == u.name; });
  return found == std::end(kUnits) ? nullptr : &*found;
}

// The parts between "_" of the last name of a dotted key.
std::vector<std::string> parts(const std::string& key) {
  std::vector<std::string> all;
  std::istringstream rest(key.substr(key.rfind('.') + 1));  // npos + 1 is 0
  for (std::string part; std::getline(rest, part, '_');) all.push_back(part);
  return all;
}

// How many of the unit of `to` one of `from` is, where the keys differ in nothing else, and in that
// but in its first part: "N" of "N_m".
std::optional<double> in_unit_of(const std::string& to, const std::string& from) {
  const std::vector<std::string> a = parts(from), b = parts(to);
  if (a.size() != b.size()) return std::nullopt;
  const auto [at, its] = std::mismatch(a.begin(), a.end(), b.begin());
  if (at == a.end() || !std::equal(at + 1, a.end(), its + 1)) return std::nullopt;
  const Unit *given = unit(*at), *wanted = unit(*its);
  const bool first = at == a.begin() || !unit(*(at - 1));
  if (!given || !wanted || given->dimension != wanted->dimension || !first) return std::nullopt;
  return given->si / wanted->si;
}

}  // namespace

std::string nearest(const std::string& name, const std::vector<std::string>& known) {
  constexpr std::size_t kLongestName = 200;
  if (name.empty() || name.size() > kLongestName) return "";
  std::string found;
  std::size_t least = kLongestName;
  for (const std::string& each : known) {
    const std::size_t far = each.starts_with(name) ? 1 : levenshtein(name, each);
    const std::size_t farthest = std::max<std::size_t>(2, std::max(name.size(), each.size()) / 3);
    if (far > farthest || far >= least) continue;
    least = far;
    found = each;
  }
  return found;
}

std::string did_you_mean(const std::string& name, const std::vector<std::string>& known) {
  const std::string near = nearest(name, known);
  return near.empty() ? "" : ": did you mean " + near + "?";
}

std::string unknown_key(const std::string& key, const nlohmann::json& value,
                        const std::string& meant) {
  const std::optional<double> factor = in_unit_of(meant, key);
  if (!factor || !value.is_number()) return "unknown key; did you mean " + meant + "?";
  char converted[32];
  std::snprintf(converted, sizeof converted, "%.12g", *factor * value.get<double>());
  return "unknown key; here it is " + meant + " = " + converted;
}

}  // namespace ferrule
