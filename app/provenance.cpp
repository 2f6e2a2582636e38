#include "app/provenance.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "capture/episode.hpp"
#include "sim/base/content_hash.hpp"
#include "sim/scene/drawn_numbers.hpp"
#include "sim/scene/extends.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kMostChanges = 8, kMostFiles = 3;  // in a line
constexpr std::size_t kShort = 10;                       // digits of a hash in a line
constexpr std::size_t kMostText = 10'000;                // bytes of a scene with its changes

std::vector<std::string> g_words;  // both set before a verb runs
std::string g_command;

// What says nothing about physics, task or numerics.
bool remark(const std::string& key) {
  return key == "name" || key == "about" || key == "$schema" || key == "planned_accuracy" ||
         key == "planned_error_bound";
}

void add_changes(const Json& value, const Json& shipped, const std::string& path,
                 std::vector<SceneChange>& changes) {
  const auto whole = [](const Json& v) { return !v.is_object() || Distribution::read(v); };
  if (whole(value) || whole(shipped)) {
    if (value != shipped) changes.push_back({path, value, shipped});
    return;
  }
  const auto inside = [&](const std::string& key) { return path.empty() ? key : path + "." + key; };
  const auto look = [&](const std::string& key) {
    if (!path.empty() || !remark(key))
      add_changes(value.value(key, Json()), shipped.value(key, Json()), inside(key), changes);
  };
  for (const auto& item : value.items()) look(item.key());
  for (const auto& item : shipped.items())
    if (!value.contains(item.key())) look(item.key());
}

std::vector<SceneChange> changes_of(const Json& value, const Json& shipped) {
  std::vector<SceneChange> changes;
  add_changes(value, shipped, "", changes);
  return changes;
}

}  // namespace

std::string shell_quoted(const std::string& argument) {
  const bool plain =
      !argument.empty() && std::all_of(argument.begin(), argument.end(), [](unsigned char c) {
        return std::isalnum(c) ||
               std::string_view("-_./=,:+@%").find(static_cast<char>(c)) != std::string_view::npos;
      });
  if (plain) return argument;
  std::string text = "'";
  for (const char c : argument) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

std::string shell_word(const std::string& argument) {
  const std::string text = shell_quoted(argument);
  return printable(text, text.size());
}

SceneChanges changes_from_shipped(const Json& document) {
  SceneChanges nearest;
  for (const std::string& name : shipped_scenes()) {
    std::vector<SceneChange> changes = changes_of(document, load_scene(name).document());
    const bool same_name = name == document.value("name", "");
    if (nearest.from.empty() || changes.size() < nearest.changes.size() ||
        (same_name && changes.size() == nearest.changes.size()))
      nearest = {name, std::move(changes)};
  }
  return nearest;
}

std::string scene_text(const Json& document, const SceneChanges& of) {
  const std::string name = document.value("name", "");
  if (of.from.empty() || of.changes.empty())
    return of.from.empty() || of.from == name ? name : name + " (as " + of.from + ")";
  std::string list;
  for (std::size_t i = 0; i < std::min(of.changes.size(), kMostChanges); ++i)
    list += (i ? ", " : "") + of.changes[i].key + " = " +
            (of.changes[i].value.is_null() ? "none" : of.changes[i].value.dump());
  if (of.changes.size() > kMostChanges)
    list += fmt::format(" and {} more (see --json)", of.changes.size() - kMostChanges);
  return of.from == name ? name + " with " + list
                         : fmt::format("{} (as {} but for {})", name, of.from, list);
}

bool same_scene(const Json& a, const Json& b) {
  return changes_of(a, b).empty();
}

Provenance& Provenance::in(const ChosenScene& chosen) {
  const Json document = chosen.scene.document();
  const Json stated = undrawn(document);  // a recording's scene has the numbers of its trial
  const SceneChanges of = changes_from_shipped(stated);
  scene_text_ = "scene " + scene_text(stated, of) + chosen.relation;
  Json changes = Json::object();
  for (const SceneChange& c : of.changes) {
    Json& change = changes[c.key] = Json::object();  // what is not there is left out
    if (!c.value.is_null()) change["value"] = c.value;
    if (!c.shipped.is_null()) change["shipped"] = c.shipped;
  }
  scene_ = {{"name", chosen.scene.name}, {"sha1", sha1(document.dump())},
            {"document", document},      {"shipped", of.from},
            {"changes", changes},        {"other_than_brought", chosen.other}};
  if (!chosen.relation.empty()) scene_["relation"] = chosen.relation.substr(2);
  std::error_code error;
  if (std::filesystem::is_regular_file(chosen.file, error))
    for (const SceneLayer& layer :
         scene_layers(parse_json(read_text(chosen.file), chosen.file), chosen.file))
      read(layer.file);
  const double bound = document.value("planned_error_bound", 0.0),
               accuracy = document.value("planned_accuracy", 0.0);
  if (bound > accuracy) {
    notes_ += fmt::format(
        "note: accuracy = {:g} is NOT REACHED: the error bound of the plan is {:.2g} "
        "(see ferrule plan)\n",
        accuracy, bound);
    scene_["accuracy_not_reached"] = {{"accuracy", accuracy}, {"error_bound", bound}};
  }
  const auto* elastic = std::get_if<ElasticFibre>(&chosen.scene.parameters.holder);
  const double handled = chosen.scene.parameters.fibre.manipulated_length_mm;
  if (elastic && elastic->free_length_mm != handled)
    notes_ += fmt::format(
        "note: holder.free_length_mm = {:g} bends, fibre.manipulated_length_mm = {:g} weighs and "
        "buckles\n",
        elastic->free_length_mm, handled);
  return *this;
}

Provenance& Provenance::seed(const std::string& of, std::uint64_t value) {
  seeds_.emplace_back(of, value);
  return *this;
}

Provenance& Provenance::read(const std::string& file) {
  return read(file, sha1_of_file(file));
}

Provenance& Provenance::read(const std::string& file, const std::string& hash) {
  read_.emplace_back(file, hash);
  return *this;
}

Provenance& Provenance::partial(const std::string& what) {
  partial_ = what;
  return *this;
}

std::string Provenance::hash_of_all() const {
  std::string all;
  for (const auto& [_, hash] : read_) all += hash;
  return sha1(all);
}

std::string Provenance::head() const {
  std::string text = printable(scene_text_, kMostText);
  for (const auto& [of, value] : seeds_)
    text += fmt::format("{}seed of {} {}", text.empty() ? "" : "; ", of, value);
  if (!text.empty()) text += "\n";
  return text + notes_;
}

std::string Provenance::foot() const {
  std::string text;
  if (!partial_.empty()) text = "PARTIAL, stopped before the end: " + partial_ + "\n";
  text += fmt::format("made by ferrule {} ({}): {}", program_version(), program_build(), g_command);
  for (std::size_t i = 0; i < read_.size(); ++i) {
    const auto& [file, hash] = read_[i];
    if (read_.size() <= kMostFiles)
      text += fmt::format("; read {} (SHA-1 {})", printable(file), hash.substr(0, kShort));
  }
  if (read_.size() > kMostFiles)
    text += fmt::format("; read {} files, {} to {} (SHA-1 of their SHA-1s {})", read_.size(),
                        printable(read_.front().first), printable(read_.back().first),
                        hash_of_all().substr(0, kShort));
  return text + "\n";
}

Json Provenance::to_json() const {
  Json json = {{"version", program_version()}, {"build", program_build()}, {"command", g_command}};
  if (!scene_.is_null()) json["scene"] = scene_;
  if (!partial_.empty()) json["partial"] = partial_;
  json["seeds"] = Json::object();
  for (const auto& [of, value] : seeds_) json["seeds"][of] = value;
  json["read"] = Json::array();
  for (const auto& [file, hash] : read_) json["read"].push_back({{"file", file}, {"sha1", hash}});
  return json;
}

std::vector<std::pair<std::string, std::string>> Provenance::columns() const {
  std::vector<std::pair<std::string, std::string>> all;
  if (!scene_.is_null()) all = {{"scene", scene_["name"]}, {"scene_sha1", scene_["sha1"]}};
  for (const auto& [of, value] : seeds_) all.emplace_back("seed_" + of, std::to_string(value));
  if (!read_.empty())
    all.emplace_back("read_sha1", read_.size() == 1 ? read_[0].second : hash_of_all());
  all.emplace_back("partial", partial_);
  all.emplace_back("version", program_version() + " (" + program_build() + ")");
  all.emplace_back("command", g_command);
  return all;
}

std::string shell_words(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + shell_word(word);
  return text;
}

std::vector<std::string> without_option(std::vector<std::string> words, const std::string& option) {
  for (auto word = words.begin(); word != words.end();)
    if (*word == option)
      word = words.erase(word, word + std::min<std::ptrdiff_t>(2, words.end() - word));
    else if (word->starts_with(option + "="))
      word = words.erase(word);
    else
      ++word;
  return words;
}

void remember_command(const std::vector<std::string>& words) {
  g_words = words;
  std::vector<std::string> shown = without_option(words, "--threads");
  shown.insert(shown.begin(), "ferrule");
  g_command = shell_words(shown);
}

const std::vector<std::string>& command_words() noexcept {
  return g_words;
}

}  // namespace ferrule
