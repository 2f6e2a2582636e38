// How something is refused, for tests.
#pragma once

#include "sim/base/json_fields.hpp"

namespace ferrule::testing {

// What `act` is refused with; "trouble: " before what is wrong with a file; empty: it is not refused.
template <class Act>
std::string refusal(const Act& act) {
  try {
    act();
  } catch (const BadInput& error) {
    return error.what();
  } catch (const FileTrouble& error) {
    return std::string("trouble: ") + error.what();
  }
  return {};
}

// Writes `good` to `file` with `value` at `pointer` and lets `read(file)` read it.
template <class Read>
std::string refusal(const std::string& file, Json good, const char* pointer, const Json& value,
                    const Read& read) {
  good[Json::json_pointer(pointer)] = value;
  write_text(file, good.dump());
  return refusal([&] { read(file); });
}

}  // namespace ferrule::testing
