#include "sim/base/shipped_files.hpp"

#include <algorithm>
#include <filesystem>

#include "sim/base/data_folder.hpp"
#include "sim/base/json_fields.hpp"
#include "sim/base/unknown_name.hpp"

namespace ferrule {

namespace fs = std::filesystem;

std::string ShippedFiles::place() const {
  return data_folder() + "/" + folder;
}

std::string ShippedFiles::find(const std::string& name_or_file,
                               const std::vector<std::string>& besides) const {
  const bool bare = name_or_file.find(".json") == std::string::npos && name_or_file[0] != '/' &&
                    name_or_file[0] != '.';
  std::error_code error;
  if (!bare || fs::is_regular_file(name_or_file, error)) return name_or_file;
  std::string shipped = place() + "/" + name_or_file + ".json";
  if (fs::exists(shipped, error)) return shipped;
  std::string message =
      name_or_file + ": no such " + file + ", and no shipped " + one + " of that name:";
  std::vector<std::string> near = names(fs::path(name_or_file).parent_path().string());
  if (near.empty()) near = names();
  near.insert(near.end(), besides.begin(), besides.end());
  for (const auto& name : near) message += " " + name;
  throw FileTrouble(message + did_you_mean(name_or_file, near));
}

std::vector<std::string> ShippedFiles::names(const std::string& within) const {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(fs::path(place()) / within, error)) {
    const fs::path& path = entry.path();
    if (path.extension() == ".json" && path.stem().extension() != ".schema")
      names.push_back((within / path.stem()).string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace ferrule
