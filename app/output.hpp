// How a verb tells its result: --json, --csv or text, and --plot.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

#include "app/provenance.hpp"

namespace ferrule {

// --json or --csv instead of text, for what ends in print_result.
struct Output {
  bool json = false, csv = false;
  bool text() const { return !json && !csv; }
};
void add_output(CLI::App& verb, Output& output);
// Prints `document` with its provenance, or as CSV the rows that it holds at `table`; nothing as
// text.
void print_result(const Output& output, Json document, const char* table,
                  const Provenance& provenance);

// --json, for what ends in print_json.
void add_json(CLI::App& verb, bool& json);
// The one JSON document of --json, on stdout.
void print_json(const Json& json);
void print_json(Json json, const Provenance& provenance);
// An array of it: `of(row)` for each of `rows`.
template <class Rows, class Of>
Json json_list(const Rows& rows, const Of& of) {
  Json list = Json::array();
  for (const auto& row : rows) list.push_back(of(row));
  return list;
}

// `x` as `format` of fmt says, or `otherwise` where it is not finite.
std::string number_or(const char* otherwise, const char* format, double x);

// What could not be written after long work is refused before it. Empty: nothing is to be written.
// Throws FileTrouble.
void expect_place_for(const std::string& file);

// --plot of a verb that draws one: SVG, and a file that says to be of another kind is refused.
void add_plot(CLI::App& verb, std::string& file, const std::string& help);

}  // namespace ferrule
