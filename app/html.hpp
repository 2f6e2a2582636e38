// Pieces of an HTML page that needs nothing beside it.
#pragma once

#include <string>
#include <vector>

#include "app/plot.hpp"

namespace ferrule {

// Text as HTML shows it, between tags and in attributes in double quotes.
std::string escaped(const std::string& text);
// The beginning of a page, up to what is in its body. The page loads nothing, and runs no script
// and has no style but its own and those of `framed`, a page that it holds in frames.
std::string html_head(const std::string& title, const std::string& framed = "");
// A table. Headings, titles and cells are HTML. On a narrow screen every row is a list of its
// cells, each beside its heading.
class HtmlTable {
 public:
  struct Column {
    std::string heading;  // without tags
    bool number = true;   // its cells are aligned to the right
  };
  explicit HtmlTable(std::vector<Column> columns);

  // A cell for every column.
  void row(const std::vector<std::string>& cells);
  // Over the rows that follow.
  void title(const std::string& title);
  // Empty where it has no rows.
  std::string html() const;

 private:
  std::vector<Column> columns_;
  std::string rows_;
};

// A plot over its caption, which is HTML. Where it has no point, the page says so.
std::string figure(const Plot& plot, const std::string& caption);

}  // namespace ferrule
