#include "app/csv.hpp"

#include <algorithm>

namespace ferrule {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",;\"\r\n") == text.npos) return text;
  std::string all = "\"";
  for (const char c : text) all += c == '"' ? "\"\"" : std::string(1, c);
  return all + "\"";
}

// What spreadsheets compute, in full width too.
bool is_formula(std::string_view cell) {
  cell.remove_prefix(std::min(cell.find_first_not_of(" \""), cell.size()));
  for (const char* sign : {"=", "+", "-", "@", "\uff1d", "\uff0b", "\uff0d", "\uff20"})
    if (cell.starts_with(sign)) return true;
  return false;
}

// A text on one line, of which terminals obey nothing. What spreadsheets would compute is marked as
// text, with the apostrophe that they take; also after a semicolon, which parts cells in some
// countries, within quotes too, as the line does not begin with them.
std::string as_text(const std::string& text) {
  const std::string line = printable(text, text.size());
  std::string marked;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find(';', at), line.size());
    const std::string cell = line.substr(at, end - at);
    marked += (at > 0 ? ";" : "") + std::string(is_formula(cell) ? "'" : "") + cell;
    at = end + 1;
  }
  return marked;
}

void add_fields(const Json& value, const std::string& name, Fields& fields) {
  if (value.is_structured()) {
    std::size_t i = 0;
    for (const auto& item : value.items())
      add_fields(
          item.value(),
          (name.empty() ? "" : name + ".") + (value.is_array() ? std::to_string(i++) : item.key()),
          fields);
    return;
  }
  const std::string text = value.is_string() ? as_text(value.get<std::string>()) : value.dump();
  const bool empty = value.is_null() || (value.is_number_float() && text == "null");
  fields.emplace_back(name, empty ? "" : text);
}

template <class Row>
auto find(Row& row, const std::string& name) {
  return std::find_if(row.begin(), row.end(),
                      [&](const auto& field) { return field.first == name; });
}

}  // namespace

std::string csv_text(const Json& rows, const Provenance& provenance) {
  std::vector<Fields> lines;
  Fields names;
  for (const Json& row : rows) {
    Fields& line = lines.emplace_back();
    add_fields(row, "", line);
    for (const auto& field : line)
      if (find(names, field.first) == names.end()) names.emplace_back(field.first, "");
  }
  for (const auto& column : provenance.columns())
    if (find(names, column.first) == names.end())
      names.emplace_back(column.first, as_text(column.second));
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i ? "," : "") + csv_field(as_text(names[i].first));
  text += "\r\n";
  for (const Fields& line : lines) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto field = find(line, names[i].first);
      text += (i ? "," : "") + csv_field(field == line.end() ? names[i].second : field->second);
    }
    text += "\r\n";
  }
  return text;
}

std::string csv_file(const Json& rows, const Provenance& provenance) {
  const std::string text = csv_text(rows, provenance);
  const bool ascii = std::all_of(text.begin(), text.end(), [](char c) { return (c & 0x80) == 0; });
  return (ascii ? "" : "\xef\xbb\xbf") + text;
}

}  // namespace ferrule
