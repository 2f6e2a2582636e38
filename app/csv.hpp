// Tables as CSV (RFC 4180).
#pragma once

#include "app/provenance.hpp"

namespace ferrule {

// One line of names, then one per object of the list `rows`. What is nested has dotted names, the
// elements of a list their number in it; a row that has no such value, null, or a number that is not
// finite leaves it empty. A text that begins with = + - @, a tab or a carriage return has an
// apostrophe before it: spreadsheets would take it for a formula. The columns of `provenance` come
// last, but for those whose names the rows have.
std::string csv_text(const Json& rows, const Provenance& provenance);
// The same as a file for people: where not all of it is ASCII it begins with the mark by which Excel
// knows UTF-8. Programs that read a pipe would take that for a part of the first name.
std::string csv_file(const Json& rows, const Provenance& provenance);

}  // namespace ferrule
