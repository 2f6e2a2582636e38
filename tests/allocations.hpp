// How often the test program has allocated on the heap: it counts its own operator new.
#pragma once

#include <cstddef>

namespace ferrule::testing {

std::size_t allocations() noexcept;

}  // namespace ferrule::testing
