#include "app/named_files.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>

#include "controller/controller_file.hpp"
#include "sim/scene/extends.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

// The document of a file that can be a scene or a controller; null: it is none.
Json document_of(const std::string& file) {
  constexpr std::uintmax_t kMost = 64 << 20;  // bytes
  std::error_code error;
  std::ifstream in(file);
  if (fs::file_size(file, error) > kMost || error || (in >> std::ws).peek() != '{') return {};
  try {
    return parse_json(read_text(file), file);
  } catch (const std::exception&) {  // whoever reads it says so
    return {};
  }
}

// A file, and what it names.
std::vector<std::string> with_named(const std::string& file) {
  std::vector<std::string> all = {file};
  const Json document = document_of(file);
  if (!document.is_object()) return all;
  if (const auto weights = document.find("weights");
      weights != document.end() && weights->is_string()) {
    const std::string beside =
        (fs::path(file).parent_path() / weights->get<std::string>()).string();
    std::error_code error;
    if (fs::is_regular_file(beside, error)) all.push_back(beside);
  }
  if (document.contains("extends")) try {
      for (const SceneLayer& layer : scene_layers(document, file))
        if (layer.file != file) all.push_back(layer.file);
    } catch (const std::exception&) {  // whoever reads it says so
    }
  return all;
}

// A scene or a controller that ships under this name.
std::vector<std::string> files_shipped(const std::string& name) {
  std::vector<std::string> all;
  const auto add = [&](const std::string& file) {
    if (file == name) return;
    for (const std::string& each : with_named(file)) all.push_back(each);
  };
  try {
    add(controller_file(name));
    add(scene_file(name));
  } catch (const std::exception&) {  // there is none
  }
  return all;
}

std::string given_value(const std::string& word) {
  return word.substr(word.find('=') + 1);
}

class Collected {
 public:
  explicit Collected(std::string except) : except_(std::move(except)) {}

  // What `name` is; false: it is nothing that can be read.
  bool add(const std::string& name, bool down) {
    std::error_code error;
    const std::size_t before = all.size();
    const bool file = fs::is_regular_file(name, error);
    if (file) all.push_back({name, with_named(name)});
    if (fs::is_directory(name, error) && !fs::equivalent(name, except_, error))
      all.push_back({name, files_of_folder(name, down, except_), true});
    if (std::vector<std::string> files; !file && !(files = files_shipped(name)).empty())
      all.push_back({name, std::move(files)});
    return all.size() > before;
  }

  std::vector<NamedFiles> all;

 private:
  std::string except_;
};

}  // namespace

std::vector<std::string> files_of_folder(const std::string& folder, bool down,
                                         const std::string& except) {
  std::vector<std::string> files;
  std::error_code error, ignored;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    // Hidden files are what other systems leave there.
    if (entry->is_regular_file(ignored) && !entry->path().filename().string().starts_with('.'))
      files.push_back(entry->path().string());
    // Python writes its compiled files where it reads.
    if (entry->is_directory(ignored) && (!down || entry->path().filename() == "__pycache__" ||
                                         fs::equivalent(entry->path(), except, ignored)))
      entry.disable_recursion_pending();
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<NamedFiles> named_files(const std::vector<std::string>& words,
                                    const std::string& except) {
  Collected found(except);
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string value = given_value(words[i]);
    if (value.starts_with('-') || found.add(value, false)) continue;
    for (const std::string& part : CLI::detail::split(value, ',')) found.add(part, false);
    const std::vector<std::string> command = CLI::detail::split_up(value);
    if (command.size() < 2) continue;
    for (const std::string& part : command)
      if (!found.add(part, true)) found.add(given_value(part), true);
  }
  return std::move(found.all);
}

}  // namespace ferrule
