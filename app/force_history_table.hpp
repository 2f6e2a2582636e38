// Which force acted when in a recording: as text, JSON, HTML and a plot.
#pragma once

#include "app/plot.hpp"
#include "capture/felt_difference.hpp"
#include "capture/force_history.hpp"

namespace ferrule {

std::string to_text(const ForceHistory& history);
std::string to_html(const ForceHistory& history);
// One object per term.
Json to_json(const TermActivity& term);
std::string to_text(const FeltDifference& difference);
Json to_json(const FeltDifference& difference);
// Magnitude of each term over time.
Plot history_plot(const Episode& episode, const Scene& scene);

}  // namespace ferrule
