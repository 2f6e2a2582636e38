#include "app/answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "app/best_rows.hpp"
#include "app/output.hpp"
#include "app/validators.hpp"
#include "app/varied_plots.hpp"

namespace ferrule {
namespace {

double number_at(const Json& row, const char* key) {
  return number_or_nan(row.value(key, Json()));
}

std::string as_percent(double share) {
  // As many digits as are left below 100 %.
  return fmt::format("{:.{}f} %", 100 * share, share > 0.99 && share < 1 ? 2 : 1);
}

std::string success(const Json& row) {
  const std::size_t feasible = row.at("feasible");
  if (feasible == 0) return "no trial, as no pair of parts fits together";
  return fmt::format("{} of {} simulated trials: {} (95 % confidence: {} to {})",
                     row.at("successes").get<std::size_t>(), feasible,
                     as_percent(row.at("success_rate")), as_percent(row.at("low")),
                     as_percent(row.at("high")));
}

// " (95 %: 0.18 to 0.19)"; nothing where the result has no interval.
std::string interval_in_words(const Json& mated, const char* low, const char* high) {
  if (!std::isfinite(number_at(mated, low))) return "";
  const double most = number_at(mated, high);
  return std::isfinite(most) ? fmt::format(" (95 %: {:.3g} to {:.3g})", number_at(mated, low), most)
                             : fmt::format(" (95 %: from {:.3g}, too few trials to say up to what)",
                                           number_at(mated, low));
}

std::string grade_in_words(const Json& grade) {
  return grade.is_string() ? "grade " + grade.get<std::string>() : "no grade";
}

// "grade C of IEC 61755-1, though the trials allow anything from grade C to grade D".
std::string grades_in_words(const Json& mated) {
  std::string text = grade_in_words(mated.at("grade")) + " of IEC 61755-1";
  const Json best = mated.value("grade_best", Json()), worst = mated.value("grade_worst", Json());
  if (best == worst) return text;
  return text + ", though the trials allow anything from " + grade_in_words(best) + " to " +
         grade_in_words(worst);
}

// "0.184 dB on average, 97 % of them up to 0.491 dB: grade C of IEC 61755-1".
std::string mated_in_words(const Json& mated) {
  return fmt::format(
      "{:.3g} dB on average{}, 97 % of them up to {:.3g} dB{}: {}", number_at(mated, "mean_dB"),
      interval_in_words(mated, "mean_low_dB", "mean_high_dB"), number_at(mated, "p97_dB"),
      interval_in_words(mated, "p97_low_dB", "p97_high_dB"), grades_in_words(mated));
}

// How long, how strong, which grade.
std::vector<std::string> besides(const Json& row) {
  std::vector<std::string> lines = {
      fmt::format("It takes {} s and the force peaks at {} uN (medians).",
                  number_or("-", "{:.3g}", number_at(row, "time_s")),
                  number_or("-", "{:.3g}", number_at(row, "peak_force_uN")))};
  const Json mated = row.value("mated", Json());
  const Json joint = row.value("mated_joint", Json());
  if (mated.is_object() && mated.at("pairs") > 0) {
    lines.push_back("Connectors that are mated at random lose " + mated_in_words(mated) + ".");
    lines.push_back("Tuned, they lose " + mated_in_words(row.at("mated_tuned")) + ".");
    if (joint.is_object()) lines.push_back("These grades are for " + joint.value("text", "") + ".");
  } else if (const double loss = number_at(row, "loss_dB"); std::isfinite(loss)) {
    lines.push_back(fmt::format("The joint with an ideal partner loses {:.3g} dB (median).", loss));
  }
  return lines;
}

// A line, what is said besides, and one more unless it is empty.
std::vector<std::string> lines_of(const std::string& first, const Json& row,
                                  const std::string& last) {
  std::vector<std::string> lines = besides(row);
  lines.insert(lines.begin(), first);
  if (!last.empty()) lines.push_back(last);
  return lines;
}

std::string verdict(const Json& row) {
  const Json target = row.value("target", Json());
  if (!target.is_object()) return "";
  const std::string kind = target.at("verdict");
  const std::string rate = fmt::format("{:.6g} %", 100 * target.at("rate").get<double>());
  if (kind == "shown")
    return "That it is more than " + rate + " is shown, wrong with a chance of at most 5 %.";
  if (kind == "refuted")
    return "That it is " + rate + " is refuted, wrong with a chance of at most 5 %.";
  return "Whether it is more than " + rate + " is open: more trials would tell.";
}

Answer of_evaluation(const Json& result) {
  const Json& rows = result.at("rows");
  Answer a;
  a.question = fmt::format("How often does {} insert the fibre, in scene {}?",
                           result.at("controller").get<std::string>(),
                           result.at("scene").get<std::string>());
  a.lines = lines_of("In " + success(rows.at(0)) + ".", rows.at(0), verdict(rows.at(0)));
  for (std::size_t k = 1; k < rows.size(); ++k)
    a.lines.push_back(rows[k].at("controller").get<std::string>() + " does so in " +
                      success(rows[k]) + ".");
  return a;
}

std::string values_in_words(const Json& values, const Json& keys) {
  std::string text;
  for (const Json& key : keys)
    text += (text.empty() ? "" : ", ") +
            in_words(key.get<std::string>(), values.at(key.get<std::string>()));
  return text;
}

std::string names_in_words(const Json& keys) {
  std::string text;
  for (std::size_t i = 0; i < keys.size(); ++i)
    text += (i == 0                 ? ""
             : i + 1 == keys.size() ? " and "
                                    : ", ") +
            in_words(keys[i].get<std::string>()).name;
  return text;
}

// "126 um: in 199 of 200 ...; 0.19 dB mated (grade C), 24 s, 28.6 uN".
std::string in_short(const Json& row) {
  const auto number = [&](const char* key, const char* format) {
    return number_or("-", format, number_at(row, key));
  };
  const Json mated = row.value("mated", Json());
  const bool pairs = mated.is_object() && mated.at("pairs") > 0;
  std::string text = pairs ? fmt::format("{:.3g} dB mated ({})", number_at(mated, "mean_dB"),
                                         grade_in_words(mated.at("grade")))
                           : number("loss_dB", "{:.3g} dB with an ideal partner");
  text += ", " + number("time_s", "{:.3g} s") + ", " + number("peak_force_uN", "{:.3g} uN");
  return row.contains("price") ? text + ", price " + row["price"].dump() : text;
}

std::string rate_in_short(const Json& row) {
  if (row.at("feasible") == 0) return "no trial";
  return fmt::format("{} of {} ({})", row.at("successes").dump(), row.at("feasible").dump(),
                     as_percent(row.at("success_rate")));
}

// Which of `rows` is best, by best_rows.hpp; `named` says which a row is.
template <class Named>
std::vector<std::string> best_in_words(const Json& rows, const std::string& prefer,
                                       const Named& named) {
  const auto [alike, best] = best_rows(rows, prefer);
  const auto told = [&](const Json& row) { return named(row) + ": in " + success(row) + "."; };
  const std::string criteria = criteria_in_words(rows);
  if (alike.size() == 1) {
    const char* rest =
        rows.size() > 1 ? "The trials tell its success from that of all others." : "";
    return lines_of(told(*best[0]), *best[0], rest);
  }
  const auto [least, most] = std::minmax_element(
      alike.begin(), alike.end(),
      [](const Json* a, const Json* b) { return a->at("success_rate") < b->at("success_rate"); });
  const std::string equal =
      fmt::format("{} of {} insert equally often, as far as the trials can tell: {} to {}.",
                  alike.size(), rows.size(), rate_in_short(**least), rate_in_short(**most));
  if (best.size() == 1) {
    std::vector<std::string> lines = lines_of(told(*best[0]), *best[0], "");
    lines.insert(
        lines.begin() + 1,
        equal + (prefer.empty()
                     ? " Of these it has the least " + criteria + ", as far as the trials can tell."
                     : " Of these it is the one with the least " + prefer + "."));
    return lines;
  }
  std::vector<std::string> lines = {
      equal, fmt::format("{} of these are not beaten, in {} at once, by another; --prefer chooses:",
                         best.size(), criteria)};
  for (const Json* row : best)
    lines.push_back(named(*row) + ": " + rate_in_short(*row) + "; " + in_short(*row) + ".");
  if (const Json joint = best[0]->value("mated_joint", Json()); joint.is_object())
    lines.push_back("Grades are for " + joint.value("text", "") + ".");
  return lines;
}

Answer of_comparison(const Json& result) {
  const Json& rows = result.at("rows");
  Answer a;
  a.question = fmt::format("Which of {} controllers inserts the fibre most often, in scene {}?",
                           rows.size(), result.at("scene").get<std::string>());
  if (rows.empty()) return a;
  a.lines = best_in_words(rows, result.value("prefer", ""),
                          [](const Json& row) { return row.at("controller").get<std::string>(); });
  return a;
}

Answer of_sweep(const Json& result) {
  const Json& rows = result.at("rows");
  const Json& keys = result.at("keys");
  Answer a;
  a.question =
      fmt::format("Which {} {} best, with {}?", names_in_words(keys),
                  keys.size() == 1 ? "is" : "are", result.at("controller").get<std::string>());
  if (rows.empty()) return a;
  a.lines = best_in_words(rows, result.value("prefer", ""),
                          [&](const Json& row) { return values_in_words(row.at("values"), keys); });
  return a;
}

// Where the contour crosses the line on which coordinate `axis` is `at`: the other coordinate there.
std::vector<double> crossings(const Json& result, std::size_t axis, double at) {
  std::vector<double> found;
  const Json &contour = result.at("contour"), &begins = result.at("contour_begins");
  for (std::size_t k = 1; k < contour.size(); ++k) {
    if (std::find(begins.begin(), begins.end(), k) != begins.end()) continue;
    const double x0 = contour[k - 1].at(axis), x1 = contour[k].at(axis),
                 y0 = contour[k - 1].at(1 - axis), y1 = contour[k].at(1 - axis);
    if ((x0 <= at) != (x1 <= at)) found.push_back(y0 + (at - x0) / (x1 - x0) * (y1 - y0));
  }
  std::sort(found.begin(), found.end());
  return found;
}

// Is the target reached at a point of a map? Empty: that is not decided.
std::optional<bool> reached_at(const Json& row) {
  if (!row.value("can_be", true)) return false;
  const Json target = row.value("target", Json());
  const std::string verdict = target.is_object() ? target.value("verdict", "") : "";
  if (verdict == "shown") return true;
  if (verdict == "refuted") return false;
  return std::nullopt;
}

// A part of a line x = const of a map, and what is known of all of it.
struct Stretch {
  enum Kind { not_reached, reached, open };
  double low, high;
  Kind kind;
};

// From one crossing of the contour to the next. A point of the map tells of the place beside it
// where the contour is not between the two. What is known takes several that are decided, and
// hardly one that says otherwise.
std::vector<Stretch> stretches(const Json& result, double x) {
  const Json& y_axis = result.at("keys").at(1);
  const std::string x_key = result.at("keys").at(0).at("key"), y_key = y_axis.at("key");
  const std::vector<double> changes = crossings(result, 0, x);
  std::vector<std::array<int, 2>> votes(changes.size() + 1);  // not reached, reached
  for (const Json& row : result.at("rows")) {
    const std::optional<bool> reached = reached_at(row);
    if (!reached) continue;
    const double row_x = row.at("values").at(x_key), row_y = row.at("values").at(y_key);
    const auto [from, to] = std::minmax(x, row_x);
    const std::vector<double> beside = crossings(result, 1, row_y);
    if (std::any_of(beside.begin(), beside.end(), [from = from, to = to](double between) {
          return from < between && between < to;
        }))
      continue;
    const auto stretch = std::lower_bound(changes.begin(), changes.end(), row_y) - changes.begin();
    ++votes[static_cast<std::size_t>(stretch)][*reached ? 1 : 0];
  }
  std::vector<Stretch> all;
  for (std::size_t i = 0; i < votes.size(); ++i) {
    const auto [no, yes] = votes[i];
    const auto by_several = [](int some, int others) { return some >= 2 && some > 4 * others; };
    const Stretch::Kind kind = by_several(yes, no)   ? Stretch::reached
                               : by_several(no, yes) ? Stretch::not_reached
                                                     : Stretch::open;
    const double high = i < changes.size() ? changes[i] : y_axis.at("high").get<double>();
    if (!all.empty() && all.back().kind == kind)
      all.back().high = high;
    else
      all.push_back({i == 0 ? y_axis.at("low").get<double>() : changes[i - 1], high, kind});
  }
  return all;
}

// "for a force limit of at least 40 uN; from 30 to 40 uN it is not decided".
std::string reached_in_words(const std::vector<Stretch>& all, const KeyInWords& y) {
  const std::string unit = y.unit.empty() ? "" : " " + y.unit;
  if (all.size() == 1)
    return all[0].kind == Stretch::reached ? "for any " + y.name
           : all[0].kind == Stretch::not_reached
               ? "for no " + y.name
               : "too few points are decided to say for which " + y.name;
  std::string reached, open;
  for (const Stretch& s : all) {
    if (s.kind == Stretch::not_reached) continue;
    std::string& text = s.kind == Stretch::reached ? reached : open;
    if (!text.empty()) text += " and ";
    if (&s == &all.front())
      text += fmt::format("up to {:.4g}{}", s.high, unit);
    else if (&s == &all.back())
      text += fmt::format(
          fmt::runtime(s.kind == Stretch::open ? "from {:.4g}{} on" : "of at least {:.4g}{}"),
          s.low, unit);
    else
      text += fmt::format("from {:.4g} to {:.4g}{}", s.low, s.high, unit);
  }
  return (reached.empty() ? "for no " + y.name + " of which it is decided"
                          : "for a " + y.name + " " + reached) +
         (open.empty() ? "" : "; " + open + " it is not decided");
}

Answer of_map(const Json& result) {
  const Json &x_axis = result.at("keys").at(0), &y_axis = result.at("keys").at(1);
  const KeyInWords x = in_words(x_axis.at("key").get<std::string>()),
                   y = in_words(y_axis.at("key").get<std::string>());
  const double low = x_axis.at("low"), high = x_axis.at("high");
  Answer a;
  a.question = fmt::format("For which {} and {} does {} insert the fibre in {:g} % of trials?",
                           x.name, y.name, result.at("controller").get<std::string>(),
                           100 * result.at("target").get<double>());
  for (const double share : {0.1, 0.5, 0.9}) {
    const double at = interpolate(low, high, share, x_axis.at("log"));
    a.lines.push_back(fmt::format("With a {} of {:.4g}{}: {}.", x.name, at,
                                  x.unit.empty() ? "" : " " + x.unit,
                                  reached_in_words(stretches(result, at), y)));
  }
  const std::size_t open = result.at("undecided");
  const double width = number_at(result, "width");
  if (std::isfinite(width))
    a.lines.push_back(fmt::format(
        "The line between is known to 1/{:.0f} of either range; each point beside it was decided "
        "with a chance of error of at most 5 %{}.",
        1 / width, open == 0 ? "" : fmt::format(", but for {} that are not decided", open)));
  if (result.value("ended_by", "") == "time")
    a.lines.push_back(
        fmt::format("The time that was given ended it; with more it goes on to 1/{:.0f}.",
                    1 / result.at("asked_width").get<double>()));
  return a;
}

// "force sensor from 81.9 to 82.7 % (95 % confidence: by +0.2 to +1.4 points)" of the rows of success
// that gain something for certain, the most first.
std::string gains(const Json& rows, double rate) {
  std::vector<Json> gained;
  for (const Json& row : rows)
    if (row.at("of") == "success" && number_at(row, "halved_change_low") > 0) gained.push_back(row);
  std::stable_sort(gained.begin(), gained.end(), [](const Json& a, const Json& b) {
    return number_at(a, "halved_change") > number_at(b, "halved_change");
  });
  std::string text;
  for (const Json& row : gained)
    text += fmt::format("{}{} from {} to {} (95 % confidence: {:+.1f} to {:+.1f} points)",
                        text.empty() ? "" : ", ", in_words(row.at("key").get<std::string>()).name,
                        as_percent(rate), as_percent(rate + number_at(row, "halved_change")),
                        100 * number_at(row, "halved_change_low"),
                        100 * number_at(row, "halved_change_high"));
  return text;
}

// "By itself start tilt makes 31 % of the variance of success, ...; the rest, 40 %, is interaction."
std::string shares(const Json& result) {
  std::vector<std::pair<double, std::string>> alone;
  for (const Json& row : result.at("rows"))
    if (row.at("of") == "success" && number_at(row, "first_low") > 0)
      alone.emplace_back(number_at(row, "first"), in_words(row.at("key").get<std::string>()).name);
  std::stable_sort(alone.begin(), alone.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::string text;
  for (const auto& [share, name] : alone)
    text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", name, 100 * share);
  const double rest = number_at(result, "interaction");
  if (!std::isfinite(rest)) return "";
  return fmt::format(
      "Of the variance of success, alone: {}. The rest, {:.0f} %, several make together.",
      text.empty() ? "nothing that these trials show" : text, 100 * rest);
}

Answer of_sensitivity(const Json& result) {
  Answer a;
  a.question = fmt::format("What decides whether {} inserts the fibre, and what would be gained?",
                           result.at("controller").get<std::string>());
  const Json& rows = result.at("rows");
  const double rate = number_at(result, "success_rate");
  const bool alike = std::all_of(rows.begin(), rows.end(), [](const Json& row) {
    return row.at("of") != "success" || row.at("total").is_null();
  });
  const std::string gained = gains(rows, rate);
  a.lines.push_back(
      alike            ? "All trials ended alike: nothing decides."
      : gained.empty() ? "Nothing that is drawn raises the success for certain where it is half as "
                         "uncertain."
                       : "Half as uncertain, each alone, raises the success: " + gained + ".");
  if (const std::string text = shares(result); !alike && !text.empty()) a.lines.push_back(text);
  a.lines.push_back(fmt::format("{} of {} simulated trials inserted the fibre.", as_percent(rate),
                                result.at("trials").get<std::size_t>()));
  return a;
}

}  // namespace

std::string row_in_words(const Json& result, const Json& row) {
  return row.contains("values") ? values_in_words(row.at("values"), result.at("keys"))
                                : row.at("controller").get<std::string>();
}

KeyInWords in_words(const std::string& key) {
  constexpr std::array kUnits = {"um_s", "um",  "nm",  "mm",   "uN",   "mrad", "deg", "dB", "Hz",
                                 "s",    "GPa", "N_m", "Pa_s", "J_m2", "J",    "V",   "K_s"};
  KeyInWords words{key.substr(key.rfind('.') + 1), ""};  // npos + 1 is 0
  for (const std::string unit : kUnits)
    if (words.unit.empty() && words.name.ends_with("_" + unit)) {
      words.name.resize(words.name.size() - unit.size() - 1);
      words.unit = unit;
    }
  std::replace(words.name.begin(), words.name.end(), '_', ' ');
  std::replace(words.unit.begin(), words.unit.end(), '_', '/');
  if (words.unit == "Pa/s") words.unit = "Pa s";
  // What these words say depends on the section: the force limit, the start's scatter.
  const std::string section = key.substr(0, key.find('.'));
  if (section == "limits") words.name += " limit";
  if (section != "limits" && section != key && section != "ferrule")
    words.name = section + " " + words.name;
  return words;
}

std::string in_words(const std::string& key, const Json& value) {
  const KeyInWords words = in_words(key);
  return words.name + " " + setting_text(value) + (words.unit.empty() ? "" : " " + words.unit);
}

std::string failures_in_words(const Json& outcomes) {
  std::vector<std::pair<std::size_t, std::string>> failed;
  std::size_t all = 0;
  for (const auto& [outcome, count] : outcomes.items()) {
    all += count.get<std::size_t>();
    if (outcome != "inserted" && count > 0) failed.emplace_back(count, outcome);
  }
  std::sort(failed.rbegin(), failed.rend());
  std::string text;
  for (auto& [count, outcome] : failed) {
    std::replace(outcome.begin(), outcome.end(), '_', ' ');
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", outcome, count);
  }
  return text.empty() ? "" : text + fmt::format(", of {} trials", all);
}

const std::map<std::string, Answer (*)(const Json&)>& answers() {
  static const std::map<std::string, Answer (*)(const Json&)> all = {
      {"evaluate", of_evaluation},
      {"compare", of_comparison},
      {"sweep", of_sweep},
      {"map", of_map},
      {"sensitivity", of_sensitivity}};
  return all;
}

}  // namespace ferrule
