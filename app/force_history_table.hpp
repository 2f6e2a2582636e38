// Which force acted when in a recording: as text, JSON, HTML and a plot.
#pragma once

#include "app/plot.hpp"
#include "capture/felt_difference.hpp"
#include "capture/force_history.hpp"

namespace ferrule {

std::string to_text(const ForceHistory& history);
// A section of a page: several in one table, each under its name, but for those without a row.
struct NamedHistory {
  std::string name;
  ForceHistory forces;
};
std::string to_html(const std::vector<NamedHistory>& histories);
// One object per term.
Json to_json(const TermActivity& term);
std::string to_text(const FeltDifference& difference);
Json to_json(const FeltDifference& difference);
// Magnitude of each term over time.
Plot history_plot(const Episode& episode, const Scene& scene);

}  // namespace ferrule
