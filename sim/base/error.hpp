// The two ways in which what comes from outside can be wrong.
#pragma once

#include <stdexcept>
#include <string>

namespace ferrule {

// Bad input: what() is one line that names the place (file and key), the value and the rule.
// The program ends with exit code 2.
struct BadInput : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A file that cannot be read or written: what() names the file and the reason. Exit code 3.
struct FileTrouble : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// A text from outside, as the name of a file, as part of a line: control characters and what is no
// UTF-8 as \xNN, the middle as ... where it is longer than `most` bytes.
std::string printable(const std::string& text, std::size_t most = 1000);

}  // namespace ferrule
