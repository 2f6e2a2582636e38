#include "app/force_history_table.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "app/html.hpp"
#include "app/output.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

std::string percent(double share) {
  return number_or("-", "{:.1f} %", 100 * share);
}

struct HistoryColumn {
  const char* heading;
  std::string (*cell)(const TermActivity& term);
};
constexpr std::array kHistoryColumns = {
    HistoryColumn{"acts", [](const TermActivity& t) { return percent(t.acts); }},
    HistoryColumn{"apart", [](const TermActivity& t) { return percent(t.apart); }},
    HistoryColumn{"touching", [](const TermActivity& t) { return percent(t.touching); }},
    HistoryColumn{"first_s",
                  [](const TermActivity& t) { return number_or("-", "{:.3f}", t.first); }},
    HistoryColumn{"last_s", [](const TermActivity& t) { return number_or("-", "{:.3f}", t.last); }},
    HistoryColumn{"median_uN",
                  [](const TermActivity& t) { return fmt::format("{:.4g}", 1e6 * t.median); }},
    HistoryColumn{"largest_uN",
                  [](const TermActivity& t) { return fmt::format("{:.4g}", 1e6 * t.largest); }},
    HistoryColumn{"reaches", [](const TermActivity& t) { return percent(t.reaches); }},
    HistoryColumn{"of_felt", [](const TermActivity& t) { return percent(t.of_felt); }},
    HistoryColumn{"noticed", [](const TermActivity& t) { return percent(t.noticed); }}};

std::string felt_text(const ForceHistory& h) {
  return fmt::format(
      "end or side touch {} of the time; at the holder, relative to rest: median {:.3f} uN, "
      "largest {:.3f} uN",
      percent(h.touching), 1e6 * h.felt_median, 1e6 * h.felt_largest);
}

}  // namespace

std::string to_text(const ForceHistory& history) {
  std::string text = fmt::format("{:<14}", "term");
  for (const HistoryColumn& column : kHistoryColumns)
    text += fmt::format(" {:>10}", column.heading);
  text += "\n";
  for (const TermActivity& term : history.terms) {
    text += fmt::format("{:<14}", info(term.term).name);
    for (const HistoryColumn& column : kHistoryColumns)
      text += fmt::format(" {:>10}", column.cell(term));
    text += "\n";
  }
  return text + felt_text(history) +
         fmt::format(
             "\nacts: share of the time; apart, touching: of the time in which nothing touches, or "
             "something\ndoes; reaches: share of the term that reaches the hand, the rest is held "
             "by the ferrule; of_felt: share\nof what is felt; noticed: share of the time in which "
             "it is {:g} N or more at the hand, and {:g} % of what is felt\n",
             kNoticedForce, 100 * kNoticedShare);
}

std::string to_html(const std::vector<NamedHistory>& histories) {
  std::vector<HtmlTable::Column> columns = {{"force", false}};
  for (const HistoryColumn& column : kHistoryColumns) {
    std::string words = column.heading;
    std::replace(words.begin(), words.end(), '_', ' ');
    columns.push_back({words});
  }
  HtmlTable table(columns);
  for (const auto& [name, forces] : histories) {
    if (forces.insertions == 0) continue;
    table.title(escaped(name) + "<br><small>" + felt_text(forces) + "</small>");
    for (const TermActivity& term : forces.terms) {
      std::vector<std::string> cells = {info(term.term).label};
      for (const HistoryColumn& column : kHistoryColumns) cells.push_back(column.cell(term));
      table.row(cells);
    }
  }
  const std::string rows = table.html();
  if (rows.empty()) return "";
  return "<h2>Which force acted when</h2>\n" + rows +
         fmt::format(
             "<p>Share of the time in which each force acts: of all, while nothing "
             "touches, while end or side do; when it acts first and last, median and largest of "
             "its magnitude then; its share that reaches the hand, its share of what is felt, and "
             "the share of the time in which a hand would notice it ({:g} N, and {:g} % of what is "
             "felt). Of several insertions all rows together, but of first and last the "
             "median.</p>\n",
             kNoticedForce, 100 * kNoticedShare);
}

Json to_json(const TermActivity& t) {
  return {{"term", info(t.term).name},
          {"share_of_time", number_or_null(t.acts)},
          {"share_apart", number_or_null(t.apart)},
          {"share_touching", number_or_null(t.touching)},
          {"first_s", number_or_null(t.first)},
          {"last_s", number_or_null(t.last)},
          {"median_uN", 1e6 * t.median},
          {"largest_uN", 1e6 * t.largest},
          {"share_reaching_hand", number_or_null(t.reaches)},
          {"share_of_felt", number_or_null(t.of_felt)},
          {"share_noticed", number_or_null(t.noticed)}};
}

std::string to_text(const FeltDifference& d) {
  const auto part = [](const FeltApart& of, const char* where) {
    return fmt::format("; where {} in {} of {}, by {:.3g} N in the median and {:.3g} N at most",
                       where, percent(of.noticed), of.stretches, of.median, of.largest);
  };
  return fmt::format(
      "at the same place, 1 um at a time, what is felt differs noticeably in {} of {}{}{}\n",
      percent(d.all.noticed), d.all.stretches, part(d.either_touches, "either touches"),
      part(d.both_touch, "both touch"));
}

Json to_json(const FeltDifference& d) {
  return {{"places", d.all.stretches},
          {"share_noticed", number_or_null(d.all.noticed)},
          {"places_touching", d.either_touches.stretches},
          {"share_noticed_touching", number_or_null(d.either_touches.noticed)},
          {"median_N", d.either_touches.median},
          {"largest_N", d.either_touches.largest},
          {"places_both_touch", d.both_touch.stretches},
          {"share_noticed_both_touch", number_or_null(d.both_touch.noticed)},
          {"median_both_touch_N", d.both_touch.median}};
}

Plot history_plot(const Episode& episode, const Scene& scene) {
  Axes axes{"time [s]", "magnitude of force [uN]", false, true, {}};
  const Eigen::Index stride = std::max<Eigen::Index>(1, episode.rows.rows() / 1500);
  for (const Term term : kAllTerms) {
    Series series{info(term).label, {}, {}, Series::points};
    for (Eigen::Index n = 0; n < episode.rows.rows(); n += stride) {
      const double force = 1e6 * episode.rows.row(n).segment<3>(force_column(term)).norm();
      if (force == 0) continue;
      series.x.push_back(episode.rows(n, kTime.begin));
      series.y.push_back(force);
    }
    if (!series.x.empty()) axes.series.push_back(series);
  }
  if (axes.series.empty()) throw BadInput("nothing to plot: no force acted in the recording");
  return {"Forces of one recording in the scene " + scene.name, {axes}};
}

}  // namespace ferrule
