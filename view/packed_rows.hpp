// Frames as text: what a replay has in a file.
#pragma once

#include <string>
#include <vector>

#include "view/frame.hpp"

namespace ferrule {

// Base64 of raw deflate (RFC 1951) of this: column by column, each number as the difference of its
// float32's bits from those of the row before (from 0 in the first one, modulo 2^32), and of each
// column first the lowest bytes of all rows, then the next ones. Nothing is lost; a column that
// does not change takes next to nothing.
std::string packed_rows(const std::vector<Frame>& frames);

}  // namespace ferrule
