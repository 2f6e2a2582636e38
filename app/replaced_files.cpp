#include "app/replaced_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "app/named_files.hpp"
#include "app/provenance.hpp"
#include "sim/base/error.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

// Options whose value is a file that is written, or a folder for such files.
constexpr std::array kWritingOptions = {"--out",        "--plot",        "--report",
                                        "--trials-out", "--export",      "--pdf",
                                        "--header",     "--torchscript", "--robomimic"};

struct WrittenPlace {
  std::string option, file;
};

// Would a verb replace a file of this name in the folder that it writes to?
bool replaced_in_folder(const std::string& verb, const std::string& option, const fs::path& file) {
  const std::string name = file.filename(), kind = file.extension();
  if (option == "--plot") return kind == ".svg" || name == "report.html";
  if (verb == "demo") return name == "controller.json" || name == "report.html";
  return verb == "submit" && kind == ".sh";
}

// Those of them that are there.
std::vector<WrittenPlace> places_written(const std::vector<std::string>& words) {
  std::vector<WrittenPlace> all;
  const auto add = [&](const std::string& option, const std::string& place) {
    std::error_code error;
    if (!fs::is_directory(place, error)) return all.push_back({option, place});
    for (const std::string& file : files_of_folder(place, false))
      if (replaced_in_folder(words.front(), option, file)) all.push_back({option, file});
  };
  bool out = false;
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string option = words[i].substr(0, words[i].find('='));
    if (std::find(kWritingOptions.begin(), kWritingOptions.end(), option) == kWritingOptions.end())
      continue;
    out = out || option == "--out";
    if (option.size() < words[i].size())
      add(option, words[i].substr(option.size() + 1));
    else if (i + 1 < words.size())
      add(option, words[++i]);
  }
  if (words.front() == "report" && !out) add("--out", "report.html");
  return all;
}

// Of a folder that is named: episodes, their journals, and a job.
bool read_in_folder(const fs::path& file) {
  const std::string kind = file.extension();
  return kind == ".h5" || kind == ".part" || kind == ".trials" || file.filename() == "job.json";
}

std::vector<std::string> files_read(std::vector<std::string> words, const std::string& job) {
  for (const char* option : kWritingOptions) words = without_option(words, option);
  std::vector<std::string> all;
  for (const NamedFiles& named : named_files(words))
    for (const std::string& file : named.files)
      if (!named.folder || read_in_folder(file)) all.push_back(file);
  for (const std::string& scene : shipped_scenes()) all.push_back(scene_file(scene));
  if (job.empty()) return all;
  for (const std::string& file : files_of_folder(job, false))
    if (read_in_folder(file)) all.push_back(file);
  for (const std::string& file : files_of_folder(job + "/learned", true)) all.push_back(file);
  return all;
}

}  // namespace

void refuse_to_replace(const std::vector<std::string>& words, const std::string& job) {
  if (words.empty()) return;
  const std::vector<WrittenPlace> written = places_written(words);
  if (written.empty()) return;
  const std::vector<std::string> read = files_read(words, job);
  std::error_code error;
  for (auto one = written.begin(); one != written.end(); ++one) {
    for (const std::string& file : read)
      if (fs::equivalent(one->file, file, error) && fs::is_regular_file(file, error))
        throw BadInput(fmt::format("{} {}: would replace {}, which {} reads: choose another name",
                                   one->option, one->file, file, words.front()));
    if (fs::exists(one->file, error) && !fs::is_regular_file(one->file, error)) continue;
    const fs::path place = fs::weakly_canonical(fs::absolute(one->file, error), error);
    for (auto other = written.begin(); other != one; ++other)
      if (one->option != other->option &&
          (fs::equivalent(one->file, other->file, error) ||
           place == fs::weakly_canonical(fs::absolute(other->file, error), error)))
        throw BadInput(fmt::format("{} {}: would replace {} {}: choose another name", one->option,
                                   one->file, other->option, other->file));
  }
}

}  // namespace ferrule
