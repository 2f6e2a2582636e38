#include "sim/scene/extends.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include "sim/scene/scene.hpp"

namespace ferrule {
namespace {

constexpr std::array kSections = {"fibre",  "ferrule", "laws",    "start", "sensor", "hand",
                                  "limits", "tangent", "success", "joint", "scaling"};

std::string extended_file(const SceneLayer& layer, const std::string& base) {
  const bool path = base.ends_with(".json") || base.starts_with('.') || base.starts_with('/');
  const auto folder = std::filesystem::path(layer.file).parent_path();
  return scene_file(path ? (folder / base).string() : base);
}

void put_over(Json& whole, const Json& document) {
  for (const auto& [key, value] : document.items()) {
    const bool section = std::find(kSections.begin(), kSections.end(), key) != kSections.end();
    if (section && value.is_object() && whole.contains(key) && whole[key].is_object())
      whole[key].update(value);
    else
      whole[key] = value;
  }
}

}  // namespace

std::vector<SceneLayer> scene_layers(const Json& document, const std::string& file) {
  constexpr std::size_t kMost = 10;
  std::vector<SceneLayer> layers = {{file, document}};
  while (layers.back().document.is_object() && layers.back().document.contains("extends")) {
    const SceneLayer& top = layers.back();
    const std::string base = JsonFields(top.document, top.file).text("extends");
    if (layers.size() == kMost)
      throw BadInput(file + ": extends more than " + std::to_string(kMost) +
                     " scenes: does one extend itself?");
    const std::string next = extended_file(top, base);
    layers.push_back({next, parse_json(read_text(next), next)});
  }
  return layers;
}

Json whole_scene(const std::vector<SceneLayer>& layers) {
  if (layers.size() == 1) return layers.front().document;
  Json whole = Json::object();
  for (auto layer = layers.rbegin(); layer != layers.rend(); ++layer) {
    whole.erase("about");  // says what the other one is
    put_over(whole, layer->document);
  }
  whole.erase("extends");
  return whole;
}

}  // namespace ferrule
