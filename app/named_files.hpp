// The files that the words of a command name, and what these bring along: what the command reads.
#pragma once

#include <string>
#include <vector>

namespace ferrule {

struct NamedFiles {
  std::string name;                // of "KEY=VALUE" the value; of a list, and of a command, a part
  std::vector<std::string> files;  // itself and what it names, or those of a folder, by their names
  bool folder = false;
};

// Of all words after the verb: files, with the scenes that one extends and the weights that one
// names; folders; names of scenes and controllers that ship; the same in a list with commas, and in
// a command (--policy), of whose folders also what is in folders there. Not `except`, a folder.
std::vector<NamedFiles> named_files(const std::vector<std::string>& words,
                                    const std::string& except = "");

// Of a folder, with those of the folders in it where it goes `down`; by their names. Not `except`.
std::vector<std::string> files_of_folder(const std::string& folder, bool down,
                                         const std::string& except = "");

}  // namespace ferrule
