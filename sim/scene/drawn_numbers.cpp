#include "sim/scene/drawn_numbers.hpp"

#include "sim/scene/scene_keys.hpp"

namespace ferrule {
namespace {

void find(const Json& value, const Json::json_pointer& at, const std::string& key,
          const std::string& file, std::vector<DrawnNumber>& found) {
  const auto within = [&](const std::string& name, const Json& part) {
    find(part, at / name, key.empty() ? name : key + "." + name, file, found);
  };
  const auto refuse = [&](const std::string& rule) {
    RefusedKey refused(file, at, key + " = " + value.dump() + ": " + rule);
    refused.value = value;
    throw refused;
  };
  try {
    if (const auto distribution = Distribution::read(value)) {
      const SceneKey* row = scene_key_of(key);
      if (row && !row->chance.may) refuse("must be a number, the same in all trials");
      found.push_back({.key = key, .distribution = *distribution});
      return;
    }
  } catch (const RefusedKey&) {
    throw;
  } catch (const BadInput& error) {
    refuse(error.what());
  }
  if (value.is_structured() && key != "drawn_from")
    for (std::size_t i = 0; const auto& part : value.items())
      within(value.is_array() ? std::to_string(i++) : part.key(), part.value());
}

}  // namespace

std::vector<DrawnNumber> drawn_numbers(const Json& document, const std::string& file) {
  std::vector<DrawnNumber> found;
  if (document.is_object()) find(document, Json::json_pointer(), "", file, found);
  return found;
}

Json at_centre(Json document, const std::vector<DrawnNumber>& drawn) {
  for (const DrawnNumber& number : drawn)
    document[pointer_to(number.key)] = as_written(number.distribution.centre());
  return document;
}

double DrawnNumber::draw(std::uint64_t seed, std::uint64_t trial,
                         std::string_view redrawn) const noexcept {
  RandomStream random(seed_of(name(), redrawn, seed), trial, key);
  return distribution.draw(random);
}

Json decided_document(Json document, const std::vector<DecidedNumber>& numbers) {
  Json was = Json::object();
  if (document.contains("tolerance")) {
    was["tolerance"] = document["tolerance"];
    document.erase("tolerance");
  }
  for (const auto& [key, value] : numbers) {
    const Json::json_pointer at = pointer_to(key);
    if (document.contains(at)) {
      was[key] = document[at];
      document[at] = as_written(value);
    } else {
      document[at] = value;
      document["drawn_from"]["added"].push_back(key);
    }
  }
  if (!was.empty()) document["drawn_from"]["was"].update(was);
  return document;
}

Json undrawn(Json document) {
  if (!document.contains("drawn_from")) return document;
  const Json from = document["drawn_from"];
  document.erase("drawn_from");
  const Json was = from.value("was", Json::object());
  for (const auto& [key, value] : was.items()) document[pointer_to(key)] = value;
  if (from.contains("tolerance")) {  // as recordings before 0.9.0 have it
    document["tolerance"] = from["tolerance"];
    document["fibre"]["diameter_um"] = from["fibre_diameter_um"];
    document["ferrule"]["bore_diameter_um"] = from["ferrule_bore_diameter_um"];
  }
  for (const Json& key : from.value("added", Json::array())) {
    const Json::json_pointer at = pointer_to(key.get<std::string>());
    if (document.contains(at)) document[at.parent_pointer()].erase(at.back());
  }
  return document;
}

}  // namespace ferrule
