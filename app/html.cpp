#include "app/html.hpp"

#include <fmt/format.h>

#include "sim/base/error.hpp"
#include "view/page_file.hpp"

namespace ferrule {
namespace {

constexpr const char* kStyle = R"(
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem;
       color: #222; background: #fff }
h1, h2 { line-height: 1.2; font-weight: 600 } h2 { margin-top: 2.5rem }
table { border-collapse: collapse; margin: 1rem 0; font-size: 0.9rem }
th, td { padding: 0.3rem 0.8rem; border-bottom: 1px solid #ddd; text-align: left }
th { vertical-align: bottom } th small { font-weight: normal }
td.n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap }
figure { margin: 1.5rem 0 } img { max-width: 100%; height: auto }
figcaption { color: #555; font-size: 0.9rem } code, pre { font-size: 0.85rem; background: #f5f5f5 }
pre { padding: 0.8rem; white-space: pre-wrap } .big { font-size: 1.25rem }
p, h1, h2, code, pre, figcaption { overflow-wrap: anywhere }
.bar { width: 7rem; height: 0.8rem; overflow: visible; background: #eee } .bar rect { fill: #56B4E9 } .bar line { stroke: #222; stroke-width: 2px }
iframe.replay { border: 1px solid #bbb; box-sizing: border-box; width: min(96vw, 1400px); aspect-ratio: 16 / 9;
  margin-left: calc(50% - min(48vw, 700px)) }
@media (max-width: 40rem) {
  table, tbody { display: block } tr.headings { display: none }
  tr { display: grid; column-gap: 1.5rem; padding: 0.5rem 0; border-bottom: 1px solid #ddd }
  tr:has(td:nth-child(9)) { grid-template-columns: 1fr 1fr }
  th, td { padding: 0.1rem 0; border: 0; min-width: 0; overflow-wrap: anywhere }
  th, td:first-child { grid-column: 1 / -1; font-weight: 600; text-align: left }
  td.n:first-child::before { content: attr(data-heading) ' ' }
  td:not(:first-child) { display: grid; grid-template-columns: 1fr auto; column-gap: 1rem; text-align: right; white-space: normal }
  td:not(:first-child)::before { content: attr(data-heading); color: #555; text-align: left }
  iframe.replay { height: 90vh; aspect-ratio: auto }
}
@media print {
  body { margin: 0; max-width: none; font-size: 11pt } h1 { font-size: 16pt } tr, figure { break-inside: avoid }
  h2 { break-after: avoid } img { max-height: 22cm } .bar { print-color-adjust: exact; -webkit-print-color-adjust: exact }
}
)";
// What a policy calls it; whoever changes it finds the new one in what the test of reports says.
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
      sources_of(framed, "style-src"), escaped(title), kStyle);
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
