#include "sim/error.hpp"

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace ferrule {
namespace {

// Bytes of the character of UTF-8 that begins there; 0: none does.
std::size_t character(const std::string& text, std::size_t at) {
  using Strict = nlohmann::json;
  for (std::size_t bytes = 1; bytes <= 4; ++bytes) try {
      (void)Strict(text.substr(at, bytes)).dump();
      return bytes;
    } catch (const Strict::exception&) {
    }
  return 0;
}

}  // namespace

std::string printable(const std::string& text, std::size_t most) {
  if (text.size() > most)
    return printable(text.substr(0, most - most / 3), most) + "..." +
           printable(text.substr(text.size() - most / 3), most);
  std::string shown;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = character(text, at);
    const auto byte = static_cast<unsigned char>(text[at]);
    char escaped[5];
    std::snprintf(escaped, sizeof escaped, "\\x%02x", byte);
    const bool control = byte < 0x20 || byte == 0x7f;
    shown += control || length == 0 ? std::string(escaped) : text.substr(at, length);
    at += std::max<std::size_t>(length, 1);
  }
  return shown;
}

}  // namespace ferrule
