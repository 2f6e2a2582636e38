// What a reader says of a JSON file with one value changed, for tests.
#pragma once

#include "sim/base/json_fields.hpp"

namespace ferrule::testing {

// Writes `good` to `file` with `value` at `pointer` and lets `read(file)` read it: its refusal,
// one of FileTrouble after "trouble: ", or nothing.
template <class Read>
std::string refusal(const std::string& file, Json good, const char* pointer, const Json& value,
                    const Read& read) {
  good[Json::json_pointer(pointer)] = value;
  write_text(file, good.dump());
  try {
    read(file);
  } catch (const BadInput& error) {
    return error.what();
  } catch (const FileTrouble& error) {
    return std::string("trouble: ") + error.what();
  }
  return {};
}

}  // namespace ferrule::testing
