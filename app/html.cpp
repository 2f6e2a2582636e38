#include "app/html.hpp"

#include <fmt/format.h>

#include <string_view>

#include "sim/base/error.hpp"
#include "view/page_file.hpp"

namespace ferrule {

extern const std::string_view kReportCss;  // report.css, by CMakeLists.txt

namespace {

// What a policy calls report.css; the test of reports says the new one where that was changed.
constexpr const char* kStyleSource = "'sha256-/EItm0N/Z6fbETlLEjcXSYoFmaaYpyx6+xakCCtsw8Y='";

// An SVG as an image of its own, so that the names in one do not meet those in another.
std::string image(const std::string& svg, const std::string& alt) {
  std::string data;
  for (const char c : svg)
    if (std::string_view("%#&\"'<>\n").find(c) != std::string_view::npos)
      data += fmt::format("%{:02X}", static_cast<unsigned char>(c));
    else
      data += c;
  return fmt::format("<img alt=\"{}\" src=\"data:image/svg+xml,{}\">\n", escaped(alt), data);
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string html_head(const std::string& title, const std::string& framed) {
  const std::string scripts = sources_of(framed, "script-src");
  return fmt::format(
      R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; {}style-src {} {}; img-src data: blob:; base-uri 'none'; form-action 'none'">
<title>{}</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>{}</style></head><body>
)",
      scripts.empty() ? "" : "script-src " + scripts + "; ", kStyleSource,
      sources_of(framed, "style-src"), escaped(title), kReportCss);
}

HtmlTable::HtmlTable(std::vector<Column> columns) : columns_(std::move(columns)) {}

void HtmlTable::row(const std::vector<std::string>& cells) {
  rows_ += "<tr>";
  for (std::size_t i = 0; i < cells.size(); ++i)
    rows_ += fmt::format("<td{} data-heading=\"{}\">{}</td>", columns_[i].number ? " class=n" : "",
                         columns_[i].heading, cells[i]);
  rows_ += "</tr>\n";
}

void HtmlTable::title(const std::string& title) {
  rows_ += fmt::format("<tr><th colspan={}>{}</th></tr>\n", columns_.size(), title);
}

std::string HtmlTable::html() const {
  if (rows_.empty()) return "";
  std::string head = "<table><tr class=headings>";
  for (const Column& column : columns_) head += "<th>" + column.heading + "</th>";
  return head + "</tr>\n" + rows_ + "</table>\n";
}

std::string figure(const Plot& plot, const std::string& caption) {
  try {
    return "<figure>\n" + image(draw_svg(plot), plot.title) + "<figcaption>" + caption +
           "</figcaption></figure>\n";
  } catch (const FileTrouble& trouble) {
    return "<p class=\"note\">" + escaped(plot.title) + ": " + escaped(trouble.what()) + "</p>\n";
  }
}

}  // namespace ferrule
