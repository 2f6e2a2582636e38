// ferrule scene: the keys of a scene with their values, for --set.
#include <fmt/format.h>

#include <algorithm>

#include "app/scene_keys.hpp"
#include "app/verb.hpp"

namespace ferrule {
namespace {

struct SceneVerbArguments {
  SceneArguments scene;
  std::vector<std::string> words;
  Output output;
};

// The value at a dotted key; null where there is none.
Json value_at(const Json& document, const std::string& key) {
  std::string path = "/" + key;
  std::replace(path.begin(), path.end(), '.', '/');
  return document.value(Json::json_pointer(path), Json());
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// Has every word in its name or its remark.
bool asked_for(const SceneKey& key, const std::vector<std::string>& words) {
  const std::string text = lower(key.key + " " + key.about);
  return std::all_of(words.begin(), words.end(),
                     [&](const std::string& word) { return text.find(lower(word)) != text.npos; });
}

int scene_verb(const SceneVerbArguments& a) {
  const ChosenScene chosen = a.scene.choose();
  Json rows = Json::array();
  for (const SceneKey& key : scene_keys())
    if (!key.object && asked_for(key, a.words))
      rows.push_back({{"key", key.key},
                      {"value", value_at(chosen.scene.document, key.key)},
                      {"about", key.about}});
  if (rows.empty()) throw BadInput("scene: no key has all of these words");
  Provenance provenance;
  provenance.in(chosen);
  if (a.output.text()) {
    fmt::print("{}", provenance.head());
    std::string about;
    for (const Json& row : rows) {
      if (row["about"] != about && !row["about"].get<std::string>().empty())
        fmt::print("\n# {}\n", row["about"].get<std::string>());
      about = row["about"];
      fmt::print("{:<42} {}\n", row["key"].get<std::string>(),
                 row["value"].is_null() ? "-" : printable(row["value"].dump()));
    }
    fmt::print("{}", provenance.foot());
  }
  print_result(a.output, {{"scene", chosen.scene.name}, {"rows", rows}}, "rows", provenance);
  return kDone;
}

}  // namespace

void add_scene(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("scene", "The keys of a scene and their values, for --set");
  auto a = std::make_shared<SceneVerbArguments>();
  verb->add_option("words", a->words, "Only keys with all these words in their name or remark")
      ->type_name("WORD...");
  a->scene.add_to(*verb);
  add_output(*verb, a->output);
  add_examples(*verb, {"scene diameter", "scene --scene bench sensor"});
  verb->callback([a, &run] { run = [a] { return scene_verb(*a); }; });
}

}  // namespace ferrule
