#include "app/html.hpp"

#include <fmt/format.h>

namespace ferrule {
namespace {

// An SVG as an image of its own, so that the names in one do not meet those in another.
std::string image(const std::string& svg, const std::string& alt) {
  std::string data;
  for (const char c : svg)
    if (c == '%' || c == '#' || c == '"' || c == '<' || c == '>' || c == '\n')
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

std::string figure(const Plot& plot, const std::string& caption) {
  return "<figure>\n" + image(draw_svg(plot), plot.title) + "<figcaption>" + caption +
         "</figcaption></figure>\n";
}

}  // namespace ferrule
