// Fuzzing from whole files, whose bytes the fuzzer then changes:
//   CXX=clang++ cmake -S . -B build-fuzz -G Ninja -DFERRULE_FUZZ=ON && ninja -C build-fuzz fuzz
//   build-fuzz/tests/scene_fuzz -max_total_time=60
#pragma once

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/base/error.hpp"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);

namespace ferrule::fuzz {

// Files to start from.
std::vector<std::string> examples();
// Reads one. May throw BadInput and FileTrouble, and nothing else.
void read(const std::string& bytes);

// A folder of this process.
inline std::string folder() {
  static const std::string made = [] {
    const auto path =
        std::filesystem::temp_directory_path() / ("ferrule-fuzz-" + std::to_string(::getpid()));
    std::filesystem::create_directories(path);
    return path.string();
  }();
  return made;
}

}  // namespace ferrule::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    ferrule::fuzz::read({reinterpret_cast<const char*>(data), size});
  } catch (const ferrule::BadInput&) {
  } catch (const ferrule::FileTrouble&) {
  }
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  static const std::vector<std::string> all = ferrule::fuzz::examples();
  const std::string& example = all[seed / 16 % all.size()];
  if (seed % 16 != 0 && size > 1) return LLVMFuzzerMutate(data, size, most);
  size = std::min(most, example.size());
  std::copy_n(example.begin(), size, data);
  return size;
}
