// Pieces of an HTML page that needs nothing beside it.
#pragma once

#include <string>

#include "app/plot.hpp"

namespace ferrule {

// Text as HTML shows it.
std::string escaped(const std::string& text);
// The beginning of a page, up to what is in its body.
std::string html_head(const std::string& title);
// A plot over its caption, which is HTML. Where it cannot be drawn, as without gnuplot, the page says
// so, and a note on stderr.
std::string figure(const Plot& plot, const std::string& caption);

}  // namespace ferrule
