// Included before all else: what emscripten of Debian 12 and its standard library lack.
#pragma once

#include <charconv>
#include <cstdlib>
#include <string>
#include <version>

namespace std {
#ifndef __cpp_lib_bit_cast
template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  return __builtin_bit_cast(To, from);
}
#endif

inline from_chars_result from_chars(const char* first, const char* last, double& value) {
  const string text(first, last);
  char* end = nullptr;
  value = strtod(text.c_str(), &end);
  return {first + (end - text.c_str()), end == text.c_str() ? errc::invalid_argument : errc()};
}
}  // namespace std

// Eigen writes some of its SSE in assembler for GCC before 6.3 and from 6 on, and has none for GCC before 4.2.
#include <Eigen/src/Core/util/Macros.h>
#undef EIGEN_GNUC_AT_LEAST
#define EIGEN_GNUC_AT_LEAST(major, minor) ((major) < 6)

// Random123 lists the processors that it was tried on.
#define R123_USE_SSE 0
#define __riscv
#include <Random123/philox.h>
#undef __riscv
