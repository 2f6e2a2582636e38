#include "sim/base/error.hpp"

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
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
    // C0, DEL, and C1, which UTF-8 spells c2 80 to c2 9f: terminals act on them.
    const bool control =
        byte(0) < 0x20 || byte(0) == 0x7f || (length == 2 && byte(0) == 0xc2 && byte(1) < 0xa0);
    // U+FFFE and U+FFFF, which are no characters: no XML can have them.
    const bool none = length == 3 && byte(0) == 0xef && byte(1) == 0xbf && byte(2) > 0xbd;
    const bool as_it_is = length > 0 && !control && !none;
    const std::size_t bytes = std::max<std::size_t>(length, 1);
    if (as_it_is) shown += text.substr(at, bytes);
    for (std::size_t i = 0; i < bytes && !as_it_is; ++i) {
      char escaped[5];
      std::snprintf(escaped, sizeof escaped, "\\x%02x", byte(i));
      shown += escaped;
    }
    at += bytes;
  }
  return shown;
}

}  // namespace ferrule
