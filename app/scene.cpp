// ferrule scene: the keys of a scene with their values, and where these come from.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "app/output.hpp"
#include "app/scene_arguments.hpp"
#include "app/scene_keys.hpp"
#include "app/verbs.hpp"
#include "sim/scene/extends.hpp"
#include "sim/scene/setting.hpp"

namespace ferrule {
namespace {

struct SceneVerbArguments {
  SceneArguments scene;
  std::vector<std::string> words;
  Output output;
};

// The value at a dotted key; null where there is none.
Json value_at(const Json& document, const std::string& key) {
  const Json::json_pointer at = pointer_to(key);
  return document.contains(at) ? document.at(at) : Json();
}

// Where a key's value comes from: --set, the scene or one that it extends, or the plan of its
// accuracy.
class Origin {
 public:
  explicit Origin(const ChosenScene& chosen, const std::vector<std::string>& settings)
      : layers_(scene_layers(parse_json(read_text(chosen.file), chosen.file), chosen.file)) {
    for (const std::string& setting : settings)
      set_.push_back(setting.substr(0, setting.find('=')));
    stated_ = whole_scene(layers_);
    for (const std::string& setting : settings) apply_setting(stated_, setting);
  }

  std::string of(const std::string& key, const Json& value) const {
    if (value.is_null()) return "";
    if (value_at(stated_, key) != value) return "plan";
    for (const std::string& set : set_)
      if (key == set || key.starts_with(set + ".")) return "--set";
    // A section is put together key by key; what is within a key is of one scene.
    const std::string whole = key.substr(0, key.find('.', key.find('.') + 1));
    for (const SceneLayer& layer : layers_)
      if (layer.document.contains(pointer_to(whole)))
        return std::filesystem::path(layer.file).stem().string();
    return "";
  }

 private:
  std::vector<SceneLayer> layers_;
  std::vector<std::string> set_;
  Json stated_;
};

// Do the words begin with a scene: a file, one in a folder, or alone the name of one that ships?
bool begin_with_scene(const std::vector<std::string>& words) {
  if (words.empty()) return false;
  const std::vector<std::string> shipped = shipped_scenes();
  std::error_code error;
  return std::filesystem::is_regular_file(words[0], error) ||
         words[0].find('/') != std::string::npos ||
         (words.size() == 1 &&
          std::find(shipped.begin(), shipped.end(), words[0]) != shipped.end());
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// An object: the key after it is one of its own.
bool holds_keys(const SceneKey& key) {
  return &key != &scene_keys().back() &&
         std::string((&key + 1)->name).starts_with(key.name + std::string("."));
}

// Has every word in its name or its remark.
bool asked_for(const SceneKey& key, const std::vector<std::string>& words) {
  const std::string text = lower(key.name + (" " + about(key)));
  return std::all_of(words.begin(), words.end(),
                     [&](const std::string& word) { return text.find(lower(word)) != text.npos; });
}

int scene_verb(SceneVerbArguments a) {
  if (a.scene.scene.empty() && begin_with_scene(a.words)) {
    a.scene.scene = a.words[0];
    a.words.erase(a.words.begin());
  }
  const ChosenScene chosen = a.scene.choose();
  const Origin origin(chosen, a.scene.settings);
  const Json document = chosen.scene.document();
  Json rows = Json::array();
  for (const SceneKey& key : scene_keys()) {
    if (holds_keys(key) || key.name == std::string("extends") || !asked_for(key, a.words)) continue;
    const Json value = value_at(document, key.name);
    rows.push_back({{"key", key.name},
                    {"value", value},
                    {"from", origin.of(key.name, value)},
                    {"about", about(key)}});
  }
  if (rows.empty()) throw BadInput("scene: no key has all of these words");
  Provenance provenance;
  provenance.in(chosen);
  if (a.output.text()) {
    fmt::print("{}", provenance.head());
    std::string remark;
    for (const Json& row : rows) {
      if (row["about"] != remark && !row["about"].get<std::string>().empty())
        fmt::print("\n# {}\n", row["about"].get<std::string>());
      remark = row["about"];
      fmt::print("{:<42} {:<20} {}\n", row["key"].get<std::string>(),
                 row["value"].is_null() ? "-" : printable(row["value"].dump()),
                 printable(row["from"].get<std::string>()));
    }
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output, {{"scene", chosen.scene.name}, {"rows", rows}}, "rows", provenance);
  return kDone;
}

}  // namespace

void add_scene(CLI::App& app, Run& run) {
  auto* verb =
      app.add_subcommand("scene", "The keys of a scene, their values, and where these come from");
  auto a = std::make_shared<SceneVerbArguments>();
  verb->add_option("words", a->words,
                   "A scene; or words: only keys with all of them in their name or remark")
      ->type_name("NAME|FILE|WORD...");
  a->scene.add_to(*verb);
  add_output(*verb, a->output);
  add_examples(*verb, {"scene tight", "scene diameter", "scene --scene bench sensor"});
  verb->callback([a, &run] { run.verb = [a] { return scene_verb(*a); }; });
}

}  // namespace ferrule
