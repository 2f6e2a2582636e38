// The table of a result: each column says how a row has it, in text and in JSON.
#pragma once

#include <fmt/format.h>

#include <functional>
#include <string>
#include <vector>

#include "sim/base/json_fields.hpp"

namespace ferrule {

template <class Row>
struct Column {
  const char* key;                       // in JSON; "": it is in the text alone
  const char* heading;                   // in the text; "": it is in JSON alone
  const char* format;                    // of fmt: alignment, width, and how a number is shown
  std::function<Json(const Row&)> cell;  // NaN is null in JSON
  const char* not_finite = "-";          // what the text has then
};

template <class Row>
using Columns = std::vector<Column<Row>>;

// A cell or a heading as `format` says: what has no such presentation is only aligned.
std::string aligned(const char* format, const Json& cell, const char* not_finite);

template <class Row>
std::string table_text(const Columns<Row>& columns, const std::vector<Row>& rows) {
  std::string text;
  const auto add_line = [&](const auto& cell_of) {
    std::string line;
    for (const Column<Row>& column : columns) {
      if (!*column.heading) continue;
      if (!line.empty()) line += ' ';
      line += aligned(column.format, cell_of(column), column.not_finite);
    }
    text += line + "\n";
  };
  add_line([](const Column<Row>& column) { return Json(column.heading); });
  for (const Row& row : rows) add_line([&](const Column<Row>& column) { return column.cell(row); });
  return text;
}
template <class Row>
void print_table(const Columns<Row>& columns, const std::vector<Row>& rows) {
  fmt::print("{}", table_text(columns, rows));
}

template <class Row>
Json table_json(const Columns<Row>& columns, const std::vector<Row>& rows) {
  Json list = Json::array();
  for (const Row& row : rows) {
    Json& object = list.emplace_back(Json::object());
    for (const Column<Row>& column : columns)
      if (*column.key) object[column.key] = column.cell(row);
  }
  return list;
}

}  // namespace ferrule
