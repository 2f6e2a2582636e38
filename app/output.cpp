#include "app/output.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <iostream>

#include "app/csv.hpp"

namespace ferrule {

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json, "One JSON document on stdout");
}

void add_output(CLI::App& verb, Output& output) {
  auto* json = verb.add_flag("--json", output.json, "One JSON document on stdout");
  verb.add_flag("--csv", output.csv, "The table as CSV on stdout, one line of names first")
      ->excludes(json);
}

void print_result(const Output& output, Json document, const char* table,
                  const Provenance& provenance) {
  if (output.csv) std::cout << csv_text(document.at(table), provenance) << std::flush;
  if (output.json) print_json(std::move(document), provenance);
}

void print_json(const Json& json) {
  std::string text;
  // DEL and C1, on which terminals act, as JSON may spell them; it spells the others so anyway.
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    const auto byte = static_cast<unsigned char>(c);
    const bool c1 = byte >= 0x80 && byte < 0xa0 && !text.empty() && text.back() == '\xc2';
    if (c1) text.pop_back();
    text += c1 || byte == 0x7f ? fmt::format("\\u{:04x}", byte) : std::string(1, c);
  }
  std::cout << text << std::endl;
}

void print_json(Json json, const Provenance& provenance) {
  json["provenance"] = provenance.to_json();
  print_json(json);
}

std::string number_or(const char* otherwise, const char* format, double x) {
  return std::isfinite(x) ? fmt::format(fmt::runtime(format), x) : std::string(otherwise);
}

void expect_place_for(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (file.empty()) return;
  if (fs::is_directory(file, error)) throw FileTrouble(file + ": is a directory");
  const fs::path folder = fs::path(file).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    throw FileTrouble(file + ": cannot be written: there is no folder " + folder.string());
  // A link is followed, a device or pipe written to, and a file renamed into its folder.
  const fs::path whole = fs::weakly_canonical(fs::absolute(file), error);
  const bool device = fs::exists(whole, error) && !fs::is_regular_file(whole, error);
  const fs::path written = device ? whole : whole.parent_path();
  if (::access(written.c_str(), W_OK) != 0)
    throw FileTrouble(file + ": cannot be written: " + std::strerror(errno));
}

void add_plot(CLI::App& verb, std::string& file, const std::string& help) {
  const auto is_svg = [](const std::string& name) {
    const std::string kind = std::filesystem::path(name).extension();
    return kind.empty() || kind == ".svg" ? std::string() : "is drawn as .svg, not " + kind;
  };
  verb.add_option("--plot", file, help)->type_name("FILE.svg")->check(CLI::Validator(is_svg, ""));
}

}  // namespace ferrule
