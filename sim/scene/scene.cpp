#include "sim/scene/scene.hpp"

#include <algorithm>
#include <cmath>

#include "sim/base/json_file.hpp"
#include "sim/base/shipped_files.hpp"
#include "sim/base/units.hpp"
#include "sim/scene/extends.hpp"
#include "sim/scene/read_scene.hpp"
#include "sim/scene/scene_keys.hpp"
#include "sim/scene/setting.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr ShippedFiles kScenes = {"scenes", "scene file", "scene"};

// Refuses the value of a dotted key.
[[noreturn]] void refuse(JsonFields fields, const std::string& key, const std::string& rule) {
  const auto dot = key.find('.');
  if (dot == std::string::npos) fields.refuse(key, rule);
  refuse(fields.object(key.substr(0, dot)), key.substr(dot + 1), rule);
}

// Of a document without distributions.
Scene scene_of_numbers(const Json& document, const std::string& file) {
  JsonFields fields(document, file);
  Scene scene{};
  read_scene(fields, document, scene);
  if (const auto found = resolve(scene)) refuse(fields, found->key, found->rule);
  return scene;
}

// Can the numbers of the document be together? Throws RefusedKey where one of them cannot be.
bool consistent(const Json& document, const std::string& file) {
  JsonFields fields(document, file);
  Scene scene{};
  read_scene(fields, document, scene);
  return !inconsistency(scene);
}

// The document without chance: each number at its centre. Where these cannot be together, though
// others can, as in the first trial of seed 0 in which they can.
Json without_chance(const Json& document, const std::vector<DrawnNumber>& drawn,
                    const std::string& file) {
  constexpr std::uint64_t kMost = 1000;
  Json centre = at_centre(document, drawn);
  if (drawn.empty() || consistent(centre, file)) return centre;
  for (std::uint64_t trial = 0; trial < kMost; ++trial) {
    Json numbers = document;
    for (const DrawnNumber& number : drawn)
      numbers[pointer_to(number.key)] = as_written(number.draw(0, trial));
    try {
      if (consistent(numbers, file)) return numbers;
    } catch (const RefusedKey&) {  // refuse_beyond says so of the number alone
    }
  }
  return centre;
}

// Why a number that is drawn is refused: `rule`, and the number as it stands in the document.
RefusedKey refusal(const Json& document, const DrawnNumber& number, const std::string& file,
                   const std::string& rule) {
  const Json::json_pointer at = pointer_to(number.key);
  RefusedKey refused(file, at, number.key + " = " + document.at(at).dump() + ": " + rule);
  refused.value = document.at(at);
  return refused;
}

constexpr const char* kMayBe = "may be drawn as what it must not be: ";

// Refuses a number whose least or largest draw its key must not have.
void refuse_beyond(const Json& document, const DrawnNumber& number, const std::string& file) {
  const Rule& rule = scene_key_of(number.key)->rule;
  for (const double extreme : number.distribution.extremes())
    if (!rule.allows(extreme))
      throw refusal(document, number, file,
                    kMayBe + number.key + " = " + as_written(extreme).dump() + ": " + rule.text);
}

}  // namespace

Scene parse_scene(const Json& document, const std::string& file) {
  const std::vector<DrawnNumber> stated = drawn_numbers(document, file);
  Json centre;
  Scene scene{};
  try {
    centre = without_chance(document, stated, file);
    scene = scene_of_numbers(centre, file);
  } catch (const RefusedKey& refused) {
    for (const DrawnNumber& number : stated)
      if (pointer_to(number.key) == refused.at)
        throw refusal(document, number, file, kMayBe + refused.why);
    throw;
  }
  for (const DrawnNumber& number : stated) {
    refuse_beyond(document, number, file);
    for (const DrawnNumber& other : scene.drawn)
      if (other.key == number.key)
        throw refusal(document, number, file, "tolerance draws it too: state one of them");
  }
  scene.drawn.insert(scene.drawn.end(), stated.begin(), stated.end());
  const std::vector<DrawnNumber> unstated = unstated_numbers(scene);
  scene.drawn.insert(scene.drawn.end(), unstated.begin(), unstated.end());
  scene.stated = std::make_shared<const Json>(document);
  return scene;
}

Json Scene::document() const {
  return decided.empty() ? *stated : decided_document(*stated, decided);
}

VariableScene::VariableScene(const Scene& scene) : scene_(scene) {
  const Json document = scene.document();
  const Json centre = without_chance(document, drawn_numbers(document, scene.name), scene.name);
  for (const SceneKey& row : scene_keys())
    if (states(scene, row.name))
      if (const Json& value = centre.at(pointer_to(row.name)); value.is_number())
        numbers_[row.name] = value.get<double>();
}

std::optional<double> VariableScene::number(const std::string& key) const {
  const auto found = numbers_.find(key);
  return found == numbers_.end() ? std::nullopt : std::optional(found->second);
}

void VariableScene::set(const std::string& key, double value) {
  numbers_.at(key) = value;
  set_number(scene_, key, value);
}

bool VariableScene::consistent() const {
  return std::all_of(
             numbers_.begin(), numbers_.end(),
             [](const auto& n) { return find_scene_key(n.first)->rule.allows(n.second); }) &&
         !inconsistency(scene_);
}

Scene load_scene(const std::string& name_or_file, const std::vector<std::string>& settings) {
  const std::string file = kScenes.find(name_or_file);
  const std::string source = settings.empty() ? file : file + " with --set";
  return read_json(file, source, [&](const Json& stated) {
    Json document = whole_scene(scene_layers(stated, file));
    for (const auto& setting : settings) apply_setting(document, setting);
    Scene scene = parse_scene(document, source);
    refuse_contradictions(scene, source);
    return scene;
  });
}

void refuse_contradictions(const Scene& scene, const std::string& file) {
  const Json document = scene.document();
  const JsonFields fields(document, file);
  const double handled = scene.parameters.fibre.manipulated_length_mm;
  const auto* elastic = std::get_if<ElasticFibre>(&scene.parameters.holder);
  if (elastic && elastic->free_length_mm > handled)
    refuse(fields, "holder.free_length_mm",
           "must not exceed the length that is handled (fibre.manipulated_length_mm)");
  const double free = elastic ? elastic->free_length_mm : handled;
  if (scene.success.depth > milli * free)
    refuse(fields, "success.depth_um",
           std::string("must not exceed the length that is free to go in (") +
               (elastic ? "holder.free_length_mm)" : "fibre.manipulated_length_mm)"));
}

std::string scene_file(const std::string& name_or_file) {
  return kScenes.find(name_or_file);
}

std::vector<std::string> shipped_scenes() {
  return kScenes.names();
}

void set_form(Json& document, Form form, const std::string& file) {
  if (!document.contains("laws") || !document["laws"].is_object()) return;
  std::string lacking;
  for (auto& [name, law] : document["laws"].items()) {
    if (!law.is_object()) continue;
    const auto term = std::find(kTermNames.begin(), kTermNames.end(), name);
    if (form == Form::printed && term != kTermNames.end() &&
        !info(static_cast<Term>(term - kTermNames.begin())).printed)
      lacking += " " + name;
    law["form"] = form == Form::printed ? "printed" : "corrected";
  }
  if (!lacking.empty()) throw BadInput(file + ": laws that the paper does not print:" + lacking);
}

}  // namespace ferrule
