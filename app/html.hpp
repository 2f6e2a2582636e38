// Pieces of an HTML page that needs nothing beside it.
#pragma once

#include <string>

#include "app/plot.hpp"

namespace ferrule {

// Text as HTML shows it.
std::string escaped(const std::string& text);
// The beginning of a page, up to what is in its body.
std::string html_head(const std::string& title);
// A plot, drawn, over its caption, which is HTML. Throws as draw_svg.
std::string figure(const Plot& plot, const std::string& caption);

}  // namespace ferrule
