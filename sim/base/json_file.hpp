// Reading a JSON file whole: what is refused in it is said with its line.
#pragma once

#include <functional>

#include "sim/base/json_fields.hpp"

namespace ferrule {

// Throws what JsonFields `refused` of `document`, which was parsed from `text`, with its line there
// if it has one. Where a key is missing and `read`, which refused it, would not know another one
// that is there, that one is refused instead: it may be the missing one, misspelt.
[[noreturn]] void refuse_with_line(const RefusedKey& refused, const Json& document,
                                   const std::string& text,
                                   const std::function<void(const Json&)>& read);

// What `read(document)` makes of a JSON file. `source` is what it calls the file in what it throws;
// that is thrown as refuse_with_line says. Throws BadInput, FileTrouble.
template <class Read>
auto read_json(const std::string& file, const std::string& source, const Read& read) {
  const std::string text = read_text(file);
  const Json document = parse_json(text, file);
  try {
    return read(document);
  } catch (const RefusedKey& refused) {
    if (refused.file != source) throw;  // of another document, within it or beside it
    refuse_with_line(refused, document, text, [&](const Json& other) { read(other); });
  }
}
template <class Read>
auto read_json(const std::string& file, const Read& read) {
  return read_json(file, file, read);
}

}  // namespace ferrule
