#include "sim/error.hpp"

#include <cstdio>

namespace ferrule {

std::string printable(const std::string& text, std::size_t most) {
  if (text.size() > most)
    return printable(text.substr(0, most - most / 3), most) + "..." +
           printable(text.substr(text.size() - most / 3), most);
  std::string shown;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    char escaped[5];
    std::snprintf(escaped, sizeof escaped, "\\x%02x", byte);
    shown += byte < 0x20 || byte == 0x7f ? std::string(escaped) : std::string(1, c);
  }
  return shown;
}

}  // namespace ferrule
