// Where what ships with the program and the libraries is.
#pragma once

#include <string>

namespace ferrule {

// share/ferrule of the installation that a program was linked with by find_package(ferrule): the
// package adds a definition of this to the program, which goes before that of the library.
// Otherwise share/ferrule of the installed program, or data of the source.
std::string data_folder();

}  // namespace ferrule
