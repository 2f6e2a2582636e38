// Nothing else may be in this file: a program with a data_folder of its own does without it.
#include "sim/base/data_folder.hpp"

#include <filesystem>

namespace ferrule {

std::string data_folder() {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path().parent_path() / "share/ferrule";
  return !error && fs::is_directory(installed / "scenes", error) ? installed.string()
                                                                 : FERRULE_DATA;
}

}  // namespace ferrule
