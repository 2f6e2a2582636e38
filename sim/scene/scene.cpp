#include "sim/scene/scene.hpp"

#include <algorithm>
#include <cmath>

#include "sim/base/json_file.hpp"
#include "sim/base/shipped_files.hpp"
#include "sim/base/units.hpp"
#include "sim/scene/extends.hpp"
#include "sim/scene/read_scene.hpp"
#include "sim/scene/setting.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr ShippedFiles kScenes = {"scenes", "scene file", "scene"};

constexpr double kMostHanging = 0.3;  // tilt of the end in free air [rad]

// Refuses the value of a dotted key.
[[noreturn]] void refuse(JsonFields fields, const std::string& key, const std::string& rule) {
  const auto dot = key.find('.');
  if (dot == std::string::npos) fields.refuse(key, rule);
  refuse(fields.object(key.substr(0, dot)), key.substr(dot + 1), rule);
}

// What chance decides unless the document states it.
void add_unstated(const Json& document, Scene& scene) {
  const auto add = [&](const char* key, const Json& distribution, const char* shared = "") {
    if (!document.contains(pointer_to(key)))
      scene.drawn.push_back({key, *Distribution::read(distribution), true, shared});
  };
  const Json all_round = {{"uniform", {0, 360}}};
  const FibreParameters& fibre = scene.parameters.fibre;
  if (fibre.curl_radius_m || fibre.cleave_deg) add("fibre.roll_deg", all_round);
  if (fibre.cleave_deg) add("fibre.cleave_direction_deg", all_round);
  if (scene.parameters.ferrule.ovality_um)
    add("ferrule.ovality_direction_deg", {{"uniform", {0, 180}}});
  const InsertionStart& start = scene.start;
  const auto scatter = [&](std::array<const char*, 2> keys, const Vector2d& mean, double sd,
                           double unit, const char* shared) {
    if (sd > 0)
      for (int i = 0; i < 2; ++i)
        add(keys[static_cast<std::size_t>(i)], {{"normal", {mean[i] / unit, sd / unit}}}, shared);
  };
  scatter({"start.y_um", "start.z_um"}, start.lateral_mean, start.lateral_sd, micro,
          "start.lateral_sd_um");
  scatter({"start.tilt_y_mrad", "start.tilt_z_mrad"}, Vector2d::Zero(), start.tilt_sd, milli,
          "start.tilt_sd_mrad");
  scatter({"start.vision_y_um", "start.vision_z_um"}, Vector2d::Zero(), start.vision_sd, micro,
          "start.vision_sd_um");
  if (scene.sensor.entrance_sd > 0)
    add("sensor.entrance_error_um", {{"normal", {0, 1e6 * scene.sensor.entrance_sd}}});
  // What fibre and ferrule are off, together.
  if (const double sd = std::sqrt(scene.joint.core_sd * scene.joint.core_sd +
                                  scene.joint.bore_sd * scene.joint.bore_sd);
      sd > 0)
    for (const char* key : {"joint.offset_y_um", "joint.offset_z_um"})
      add(key, {{"normal", {0, 1e6 * sd}}});
}

// Of a document without distributions.
Scene scene_of_numbers(const Json& document, const std::string& file) {
  JsonFields fields(document, file);
  Scene scene{};
  read_scene(fields, document, scene);
  if (const auto found = inconsistency(scene)) refuse(fields, found->key, found->rule);
  scene.world = make_world(scene.parameters);
  if (scene.world.holder.sag.tail<2>().norm() > kMostHanging)
    refuse(fields, "holder.free_length_mm",
           "must be so short that the fibre's end hangs tilted by no more than " +
               Json(kMostHanging).dump() + " rad under its weight: tilts are taken as small");
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
    for (const DrawnNumber& number : drawn) {
      RandomStream random(0, trial, number.key);
      numbers[pointer_to(number.key)] = as_written(number.distribution.draw(random));
    }
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

// Refuses a number whose least or largest draw its key must not have; `centre` is allowed.
void refuse_beyond(const Json& document, const Json& centre, const DrawnNumber& number,
                   const std::string& file) {
  for (const double extreme : number.distribution.extremes()) {
    Json changed = centre;
    changed[pointer_to(number.key)] = as_written(extreme);
    JsonFields fields(changed, file);
    Scene scene{};
    try {
      read_scene(fields, changed, scene);
    } catch (const RefusedKey& refused) {
      throw refusal(document, number, file, kMayBe + refused.why);
    }
  }
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
    refuse_beyond(document, centre, number, file);
    for (const DrawnNumber& other : scene.drawn)
      if (other.key == number.key)
        throw refusal(document, number, file, "tolerance draws it too: state one of them");
  }
  scene.drawn.insert(scene.drawn.end(), stated.begin(), stated.end());
  add_unstated(document, scene);
  scene.document = document;
  return scene;
}

VariableScene::VariableScene(const Scene& scene) : scene_{} {
  std::vector<BoundNumber> bound;
  const Json centre =
      without_chance(scene.document, drawn_numbers(scene.document, scene.name), scene.name);
  JsonFields fields(centre, scene.name, &bound);
  read_scene(fields, centre, scene_);
  for (BoundNumber& number : bound) {
    const double value = centre.at(pointer_to(number.key)).get<double>();
    numbers_.push_back({std::move(number), value});
  }
}

std::optional<double> VariableScene::number(const std::string& key) const {
  for (const Number& n : numbers_)
    if (n.bound.key == key) return n.set;
  return std::nullopt;
}

void VariableScene::set(const std::string& key, double value) {
  for (Number& n : numbers_)
    if (n.bound.key == key) {
      n.set = value;
      if (n.bound.value) *n.bound.value = n.bound.unit * value;
    }
}

bool VariableScene::consistent() const {
  return std::all_of(numbers_.begin(), numbers_.end(),
                     [](const Number& n) { return n.bound.rule.allows(n.set); }) &&
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
  const JsonFields fields(scene.document, file);
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
