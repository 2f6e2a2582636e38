// Parts of the program that need packages few have installed are libraries of their own: built
// where the package was found, and loaded when first called.
#pragma once

#include <string>

namespace ferrule {

// The address of `symbol` in library `file`, which is in ../lib/ferrule of an installed program or
// in the build's folder. Throws BadInput "this program was built without WHAT" if it was not built,
// where `what` also says how to get it, and FileTrouble if it cannot be loaded.
const void* loaded_symbol(const std::string& file, const std::string& symbol,
                          const std::string& what);

// `library` and what to do where the program was built without it, as `what` above.
std::string built_with(const std::string& library, const std::string& package);

}  // namespace ferrule
