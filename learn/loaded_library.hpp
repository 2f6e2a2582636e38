// Parts of the program that need packages few have installed are libraries of their own: built
// where the package was found, and loaded when first called.
#pragma once

#include <string>

namespace ferrule {

// The address of `symbol` in library `file`, which is in ../lib/ferrule of an installed program or
// in the build's folder. Throws BadInput naming the package to install if it was not built, and
// FileTrouble if it cannot be loaded.
const void* loaded_symbol(const std::string& file, const std::string& symbol,
                          const std::string& package);

}  // namespace ferrule
