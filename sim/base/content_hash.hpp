// A hash of a file's bytes, to tell whether it is the one that was meant. Not a protection against
// someone who wants to deceive.
#pragma once

#include <string>

namespace ferrule {

// SHA-1 as 40 hexadecimal digits, as sha1sum prints it.
std::string sha1(const std::string& bytes);

}  // namespace ferrule
