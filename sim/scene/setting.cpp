#include "sim/scene/setting.hpp"

#include <charconv>
#include <cmath>
#include <optional>

namespace ferrule {
namespace {

constexpr const char *kFibre = "fibre.diameter_um", *kBore = "ferrule.bore_diameter_um";
constexpr const char* kForms = "a tolerance as 126+-0.3, 125.5+1/-0 or 125.2..126.5";

std::optional<double> number(const std::string& text) {
  double value = 0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || read.ec != std::errc() || read.ptr != text.data() + text.size())
    return std::nullopt;
  return value;
}

struct Band {
  double low, middle, high;
  std::optional<double> sd{};  // of a fibre that is normal within it
};

std::optional<Band> band(std::string text) {
  std::erase(text, ' ');
  const auto dots = text.find(".."), sign = text.find("+-"), slash = text.find("/-");
  const auto plus = text.find('+');
  if (dots != text.npos) {
    const auto low = number(text.substr(0, dots)), high = number(text.substr(dots + 2));
    if (!low || !high || !(*low <= *high)) return std::nullopt;
    return Band{*low, (*low + *high) / 2, *high};
  }
  if (sign != text.npos) {
    const auto nominal = number(text.substr(0, sign)), half = number(text.substr(sign + 2));
    if (!nominal || !half || !(*half >= 0)) return std::nullopt;
    return Band{*nominal - *half, *nominal, *nominal + *half, *half / 3};
  }
  if (plus == text.npos || slash == text.npos || slash < plus) return std::nullopt;
  const auto nominal = number(text.substr(0, plus));
  const auto above = number(text.substr(plus + 1, slash - plus - 1));
  const auto below = number(text.substr(slash + 2));
  if (!nominal || !above || !below || !(*above >= 0 && *below >= 0)) return std::nullopt;
  const double low = *nominal - *below, high = *nominal + *above;
  return Band{low, (low + high) / 2, high};
}

// 126 rather than 126.0: the same text, and so the same hash, as in a file.
Json as_written(double x) {
  return x == std::round(x) && std::abs(x) < 1e15 ? Json(std::llround(x)) : Json(x);
}

void set_value(Json& document, const std::string& setting, const std::string& key,
               const Json& value) {
  Json* place = &document;
  for (std::size_t from = 0;;) {
    const auto dot = key.find('.', from);
    const std::string part = key.substr(from, dot == std::string::npos ? dot : dot - from);
    if (part.empty()) throw BadInput("--set " + setting + ": empty name in the dotted key");
    if (place->is_null()) *place = Json::object();
    if (!place->is_object())
      throw BadInput("--set " + setting + ": \"" + key.substr(0, from ? from - 1 : 0) +
                     "\" is not an object");
    place = &(*place)[part];
    if (dot == std::string::npos) break;
    from = dot + 1;
  }
  *place = value;
}

void set_tolerance(Json& document, const std::string& key, const Band& band) {
  Json& tolerance = document["tolerance"];
  if (!tolerance.is_object()) {
    const Json::json_pointer at("/ferrule/bore_diameter_um");
    const Json width = document.contains(at) ? document.at(at) : Json();
    tolerance = {{"fibre_diameter_sd_um", 0}, {"bore_diameter_um", {width, width}}};
  }
  if (key == kBore) {
    tolerance["bore_diameter_um"] = {band.low, band.high};
    return;
  }
  tolerance.erase("fibre_diameter_um");
  tolerance.erase("fibre_diameter_sd_um");
  if (band.sd)
    tolerance["fibre_diameter_sd_um"] = *band.sd;
  else
    tolerance["fibre_diameter_um"] = {band.low, band.high};
}

// Parts that are drawn are drawn from the tolerance: a diameter beside it would say nothing.
void refuse_if_drawn(const Json& document, const std::string& setting, const std::string& key) {
  const std::string drawn = key == kBore ? "bore_diameter_um" : "fibre_diameter_um";
  if (document.contains(Json::json_pointer("/tolerance/" + drawn)))
    throw BadInput("--set " + setting + ": the scene draws it from tolerance." + drawn +
                   "; set that, or " + kForms + ", or tolerance=null before it");
}

}  // namespace

Json value_of(const std::string& text) {
  Json value = Json::parse(text, nullptr, false);
  return value.is_discarded() ? Json(text) : value;
}

void apply_setting(Json& document, const std::string& setting) {
  const auto equals = setting.find('=');
  if (equals == std::string::npos || equals == 0)
    throw BadInput("--set " + setting + ": must be dotted.key=value");
  const std::string key = setting.substr(0, equals);
  const Json value = value_of(setting.substr(equals + 1));
  const bool diameter = key == kFibre || key == kBore;
  std::optional<Band> tolerated;
  if (value.is_string()) tolerated = band(value.get<std::string>());
  if (tolerated && !diameter)
    throw BadInput("--set " + setting + ": only " + kFibre + " and " + kBore + " take a tolerance");
  if (diameter && value.is_string() && !tolerated)
    throw BadInput("--set " + setting + ": must be a number, or " + kForms);
  if (diameter && !tolerated) refuse_if_drawn(document, setting, key);
  set_value(document, setting, key, tolerated ? as_written(tolerated->middle) : value);
  if (tolerated) set_tolerance(document, key, *tolerated);
}

}  // namespace ferrule
