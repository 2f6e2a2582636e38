#include "sim/scene/setting.hpp"

#include <algorithm>

#include "sim/scene/distribution.hpp"

namespace ferrule {
namespace {

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

// A diameter that is set is not drawn by the tolerance.
void end_tolerance(Json& document, const std::string& key) {
  const auto tolerance = document.find("tolerance");
  if (tolerance == document.end() || !tolerance->is_object()) return;
  if (key == "ferrule.bore_diameter_um") tolerance->erase("bore_diameter_um");
  if (key == "fibre.diameter_um") {
    tolerance->erase("fibre_diameter_um");
    tolerance->erase("fibre_diameter_sd_um");
  }
  if (tolerance->empty()) document.erase(tolerance);
}

// What the document has at the dotted key; null: nothing.
Json now_at(const Json& document, const std::string& key) {
  const Json::json_pointer at = pointer_to(key);
  return document.contains(at) ? document.at(at) : Json();
}

// A diameter that the tolerance draws is a number besides: the middle, where it was drawn.
void end_drawn(Json& document) {
  const Json tolerance = document.value("tolerance", Json());
  const auto end = [&](const char* key, std::initializer_list<const char*> by) {
    const Json now = now_at(document, key);
    const auto drawn = Distribution::read(now);
    if (drawn &&
        std::any_of(by.begin(), by.end(), [&](const char* k) { return tolerance.contains(k); }))
      document[pointer_to(key)] = as_written(drawn->centre());
  };
  end("ferrule.bore_diameter_um", {"bore_diameter_um"});
  end("fibre.diameter_um", {"fibre_diameter_um", "fibre_diameter_sd_um"});
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
  const Json now = now_at(document, key);
  if (!value.is_string() || now.is_string()) {
    set_value(document, setting, key, value);
  } else if (const auto drawn = distribution_of(value.get<std::string>())) {
    set_value(document, setting, key, *drawn);
  } else {
    if (now.is_number() || (now.is_object() && Distribution::read(now)))
      throw BadInput("--set " + setting +
                     ": must be a number, or drawn as 126+-0.3, 125.5+1/-0 or 125.2..126.5");
    set_value(document, setting, key, value);
  }
  end_tolerance(document, key);
  if (key.starts_with("tolerance")) end_drawn(document);
}

}  // namespace ferrule
