// JSON files that ship with the program, in folders of their own (sim/base/data_folder.hpp).
#pragma once

#include <string>
#include <vector>

namespace ferrule {

struct ShippedFiles {
  const char* folder;
  const char *file, *one;  // what messages call any such file, and one that ships

  // A file, or the bare name of one that ships. Throws FileTrouble if neither is there; it names
  // those that ship, and `besides`.
  std::string find(const std::string& name_or_file,
                   const std::vector<std::string>& besides = {}) const;
  // Sorted; schemas are not among them. Of a folder within: "ladder/a".
  std::vector<std::string> names(const std::string& within = "") const;

 private:
  std::string place() const;
};

}  // namespace ferrule
