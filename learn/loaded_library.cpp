#include "learn/loaded_library.hpp"

#include <dlfcn.h>

#include <filesystem>

#include "sim/base/error.hpp"

namespace ferrule {

namespace fs = std::filesystem;

const void* loaded_symbol(const std::string& file, const std::string& symbol,
                          const std::string& what) {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  fs::path path = program.parent_path() / FERRULE_LOADED_FROM_PROGRAM / file;
  if (!fs::exists(path, error)) path = fs::path(FERRULE_LOADED_BUILT) / file;
  if (!fs::exists(path, error)) throw BadInput("this program was built without " + what);
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  const void* address = library ? ::dlsym(library, symbol.c_str()) : nullptr;
  if (!address) throw FileTrouble(std::string("cannot be loaded: ") + ::dlerror());
  return address;
}

std::string built_with(const std::string& library, const std::string& package) {
  return library + ": install " + package + ", configure with CMake again and build";
}

}  // namespace ferrule
