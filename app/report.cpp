// ferrule report: a page for those who decide, of results that evaluate, compare, sweep, map and
// sensitivity wrote as JSON.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>

#include "app/answers.hpp"
#include "app/best_rows.hpp"
#include "app/html.hpp"
#include "app/output.hpp"
#include "app/scene_keys.hpp"
#include "app/varied_plots.hpp"
#include "app/varied_scene.hpp"
#include "app/verbs.hpp"
#include "sim/base/child_process.hpp"
#include "sim/base/json_file.hpp"

namespace ferrule {
namespace {

struct ReportArguments {
  std::vector<std::string> results;
  std::string out = "report.html", pdf;
  PreferArguments prefer;
};

struct Result {
  std::string file, verb;
  Json json;
  Answer answer{};
};

// The verb that wrote it; empty: none of ours did.
std::string verb_of(const Json& json) {
  const Json::json_pointer command("/provenance/command"), rows("/rows"),
      scene("/provenance/scene/document");
  if (!json.is_object() || !json.contains(command) || !json[command].is_string() ||
      !json.contains(rows) || !json[rows].is_array() || !json.contains(scene))
    return "";
  const auto words = CLI::detail::split(json[command].get<std::string>(), ' ');
  return words.size() > 1 ? words[1] : "";
}

// Is something to be chosen among its rows?
bool is_choice(const Result& r) {
  return r.verb == "sweep" || r.verb == "compare";
}

// The rows of controllers as those of points.
void shorten_rows(Json& rows) {
  for (Json& row : rows) {
    Json shorter = short_row(row);
    shorter["controller"] = row.at("controller");
    row = std::move(shorter);
  }
}

Result read_result(const std::string& file, const PreferArguments& prefer) {
  Result result{file, "", parse_json(read_text(file), file)};
  result.verb = verb_of(result.json);
  const auto found = answers().find(result.verb);
  if (found == answers().end())
    throw BadInput(printable(file) +
                   ": must be what evaluate, compare, sweep, map or sensitivity wrote with --json");
  try {
    if (result.verb == "evaluate" || result.verb == "compare") shorten_rows(result.json.at("rows"));
    if (is_choice(result)) prefer.put_into(result.json);
    result.answer = found->second(result.json);
  } catch (const Json::exception& error) {
    throw BadInput(
        fmt::format("{}: is not whole as it was written: {}", printable(file), error.what()));
  }
  return result;
}

std::string paragraph(const std::string& text, const char* kind = "") {
  return fmt::format("<p{}>{}</p>\n", kind, escaped(text));
}

std::string answers_section(const std::vector<Result>& results) {
  std::string html;
  for (const Result& r : results) {
    const Answer& a = r.answer;
    html += "<h1>" + escaped(a.question) + "</h1>\n";
    for (const std::string& line : a.lines)
      html += paragraph(line, &line == &a.lines.front() ? " class=big" : "");
    if (r.json["provenance"].contains("partial"))
      html += paragraph("This is a part, stopped before its end: " +
                        r.json["provenance"]["partial"].get<std::string>() + ".");
  }
  return html + paragraph("All trials are simulated; none of it was measured on hardware.");
}

std::string shown(const char* format, const Json& value) {
  return number_or("&ndash;", format, number_or_nan(value));
}

// A bar over the interval of a success rate, with a mark at the rate.
std::string bar(const Json& rate, const Json& low, const Json& high) {
  if (!rate.is_number()) return "";
  return fmt::format(
      "<svg class=bar aria-hidden=true><rect x=\"{0:.2f}%\" width=\"{1:.2f}%\" height=\"100%\"/>"
      "<line x1=\"{2:.2f}%\" x2=\"{2:.2f}%\" y2=\"100%\"/></svg>",
      100 * low.get<double>(), 100 * (high.get<double>() - low.get<double>()),
      100 * rate.get<double>());
}

// "C", or with what the intervals allow "C (B to C)".
std::string grades(const Json& mated) {
  const auto word = [](const Json& grade) {
    return grade.is_string() ? escaped(grade.get<std::string>()) : std::string("&ndash;");
  };
  if (!mated.is_object() || mated.at("pairs") == 0) return "&ndash;";
  const Json best = mated.value("grade_best", Json()), worst = mated.value("grade_worst", Json());
  return best == worst
             ? word(mated.at("grade"))
             : fmt::format("{} ({} to {})", word(mated.at("grade")), word(best), word(worst));
}

// "0.18 (0.17 to 0.19)".
std::string with_interval(const Json& of, const char* value, const char* low, const char* high) {
  if (!of.is_object()) return "&ndash;";
  std::string text = shown("{:.3g}", of.value(value, Json()));
  if (!of.value(low, Json()).is_number()) return text;
  return text + " (" + shown("{:.3g}", of[low]) + " to " + shown("{:.3g}", of.value(high, Json())) +
         ")";
}

// What connectors lose: those of a row mated with each other, or if none were each with an ideal
// partner.
constexpr std::array kMatedColumns = {"mated, mean [dB], 95 %", "97 % [dB], 95 %", "grade"};
constexpr const char* kIdealColumn = "loss with an ideal partner [dB]";

void add_losses(const Json& row, bool mated, std::vector<std::string>& cells) {
  if (!mated) return cells.push_back(shown("{:.3g}", row.at("loss_dB")));
  const Json m = row.value("mated", Json());
  cells.push_back(with_interval(m, "mean_dB", "mean_low_dB", "mean_high_dB"));
  cells.push_back(with_interval(m, "p97_dB", "p97_low_dB", "p97_high_dB"));
  cells.push_back(grades(m));
}

// Of controllers (evaluate, compare) or of points (sweep).
std::string rows_table(const Result& r) {
  const bool points = r.verb == "sweep";
  const Json& rows = r.json.at("rows");
  const auto has = [&](const char* key) {
    return std::any_of(rows.begin(), rows.end(),
                       [&](const Json& row) { return row.contains(key); });
  };
  const bool mated = has("mated"), priced = has("price");
  std::vector<HtmlTable::Column> columns;
  if (points)
    for (const Json& key : r.json.at("keys")) {
      const KeyInWords words = in_words(key.get<std::string>());
      columns.push_back(
          {escaped(words.name + (words.unit.empty() ? "" : " [" + words.unit + "]")), false});
    }
  else
    columns.push_back({"controller", false});
  for (const char* heading :
       {"inserted", "success [%]", "95 %", "0 to 100 %", "time [s]", "peak force [uN]"})
    columns.push_back({heading});
  if (mated)
    for (const char* heading : kMatedColumns) columns.push_back({heading});
  if (!mated) columns.push_back({kIdealColumn});
  if (priced) columns.push_back({"price"});
  HtmlTable table(columns);
  for (const Json& row : rows) {
    std::vector<std::string> cells;
    if (points)
      for (const Json& key : r.json.at("keys"))
        cells.push_back(escaped(setting_text(row.at("values").at(key.get<std::string>()))));
    else
      cells.push_back(escaped(row.at("controller").get<std::string>()));
    const Json &low = row.at("low"), &high = row.at("high");
    cells.insert(
        cells.end(),
        {escaped(row.at("successes").dump() + " of " + row.at("feasible").dump()),
         number_or("&ndash;", "{:.4g}", 100 * number_or_nan(row.at("success_rate"))),
         fmt::format("{:.4g} to {:.4g}", 100 * number_or_nan(low), 100 * number_or_nan(high)),
         bar(row.at("success_rate"), low, high), shown("{:.3g}", row.at("time_s")),
         shown("{:.3g}", row.at("peak_force_uN"))});
    add_losses(row, mated, cells);
    if (priced) cells.push_back(shown("{:.6g}", row.value("price", Json())));
    table.row(cells);
  }
  return table.html();
}

// What the grades of a result are for; the same for all of its rows but where the joint is swept.
std::string joint_section(const std::vector<Result>& results) {
  HtmlTable table({{"joint", false}, {"value"}, {"from", false}});
  std::vector<std::string> told;
  for (const Result& r : results)
    for (const Json& row : r.json.at("rows")) {
      const Json joint = row.value("mated_joint", Json());
      if (!joint.is_object() || row.at("mated").at("pairs") == 0) continue;
      if (std::find(told.begin(), told.end(), joint.dump()) != told.end()) continue;
      told.push_back(joint.dump());
      const Json& assumed = joint.at("assumed");
      for (const auto& [key, value] : joint.items()) {
        if (key == "assumed" || key == "text" || value.is_null()) continue;
        const bool is_assumed =
            std::find(assumed.begin(), assumed.end(), Json(key)) != assumed.end();
        std::string text;
        for (const Json& each : value.is_array() ? value : Json::array({value}))
          text += (text.empty() ? "" : ", ") + each.dump();
        table.row({"<code>joint." + escaped(key) + "</code>",
                   escaped(text + " " + in_words(key).unit),
                   is_assumed ? "assumed: the scene does not state it" : "the scene"});
      }
    }
  const std::string html = table.html();
  return html.empty() ? ""
                      : "<h2>The joint that the grades are for</h2>\n" + html +
                            paragraph("A grade holds at all of these wavelengths.");
}

std::string sensitivity_table(const Result& r) {
  HtmlTable table({{"decided by chance", false},
                   {"of", false},
                   {"first order"},
                   {"95 %"},
                   {"total"},
                   {"95 %"},
                   {"half as uncertain"},
                   {"change"},
                   {"95 %"}});
  for (const Json& row : r.json.at("rows")) {
    if (!row.at("total").is_number()) continue;
    const auto number = [&](const char* key, const char* format) {
      return shown(format, row.value(key, Json()));
    };
    const auto interval = [&](const char* low, const char* high, const char* format) {
      return number(low, format) + " to " + number(high, format);
    };
    table.row({escaped(in_words(row.at("key").get<std::string>()).name),
               escaped(row.at("of").get<std::string>()), number("first", "{:.2f}"),
               interval("first_low", "first_high", "{:.2f}"), number("total", "{:.2f}"),
               interval("low", "high", "{:.2f}"), number("halved", "{:.4g}"),
               number("halved_change", "{:+.3g}"),
               interval("halved_change_low", "halved_change_high", "{:+.3g}")});
  }
  return table.html() +
         paragraph(
             "Indices of Sobol. First order: the share of the variance that it makes by itself. "
             "Total: with all that it does together with others, so that totals are no shares of a "
             "whole. Half as uncertain: what the same trials give with half the standard deviation "
             "or width; of success the rate, of the others the median.");
}

std::string picture(const Result& r) {
  if (r.verb == "sensitivity") return sensitivity_table(r);
  if (r.verb == "map")
    return figure(map_plot(r.json),
                  escaped(fmt::format("{} trials at {} points. A uniform grid as fine would have "
                                      "taken {} trials.",
                                      r.json.at("trials").dump(), r.json.at("rows").size(),
                                      r.json.at("uniform_grid_trials").dump())));
  const std::string table = rows_table(r);
  return r.verb == "sweep" && !r.json.at("rows").empty()
             ? figure(sweep_plot(r.json),
                      "Medians of time and loss are of the trials that inserted.") +
                   table
             : table;
}

using Varied = std::map<std::string, std::string>;  // by key

// What a sweep or a map varied, by key: "40, 60, 80", "10..200".
Varied varied_by(const Result& r) {
  std::map<std::string, std::string> varied;
  if (r.verb == "sweep")
    for (const Json& key : r.json.at("keys")) {
      std::vector<std::string> values;
      for (const Json& row : r.json.at("rows"))
        if (const std::string value = setting_text(row.at("values").at(key.get<std::string>()));
            std::find(values.begin(), values.end(), value) == values.end())
          values.push_back(value);
      varied[key.get<std::string>()] = fmt::format("{}", fmt::join(values, ", "));
    }
  if (r.verb == "map")
    for (const Json& axis : r.json.at("keys"))
      varied[axis.at("key").get<std::string>()] =
          axis.at("low").dump() + ".." + axis.at("high").dump();
  return varied;
}

// What damages the fibre, beside the limit on the force: of a sweep at the best of its points, of a
// map at all of them.
std::string damage_paragraph(const Result& r) {
  const Json& rows = r.json.at("rows");
  std::vector<Json> all;
  if (r.verb == "map") {
    for (const Json& row : rows)
      if (row.contains("damage")) all.push_back(row.at("damage"));
  } else if (r.verb == "sweep") {
    if (!rows.empty())
      for (const Json* best : best_rows(rows, r.json.value("prefer", "")).best)
        if (best->contains("damage")) all.push_back(best->at("damage"));
  } else if (r.json.contains("damage")) {
    all.push_back(r.json.at("damage"));
    if (!all[0].contains("limit_uN"))  // of an older program
      all[0]["limit_uN"] = r.json["provenance"]["scene"]["document"].at("limits").at("force_uN");
  }
  if (all.empty()) return "";
  const auto ends = [&](const char* key, const char* text, const char* between) {
    const auto less = [&](const Json& a, const Json& b) {
      return number_or_nan(a.at(key)) < number_or_nan(b.at(key));
    };
    const auto [least, most] = std::minmax_element(all.begin(), all.end(), less);
    const std::string low = setting_text(least->at(text)), high = setting_text(most->at(text));
    return low == high ? low : low + between + high;
  };
  return paragraph(fmt::format("{} force damages the fibre first by {}; the force limit {} {} uN.",
                               r.verb == "sweep" ? "At the best of the points a" : "A",
                               ends("force_uN", "text", ", and at another point by "),
                               r.verb == "sweep" ? "there is" : "is",
                               ends("limit_uN", "limit_uN", " to ")));
}

// What ended the trials that failed; of a map all of its points, of a sweep the best ones.
std::string limits_section(const Result& r) {
  std::string html;
  const auto add = [&](const std::string& who, const Json& outcomes) {
    const std::string failed = failures_in_words(outcomes);
    html += paragraph(who + ": " + (failed.empty() ? "no trial failed" : failed) + ".");
  };
  const Json& rows = r.json.at("rows");
  if (r.verb == "evaluate" || r.verb == "compare")
    for (const Json& row : rows) add(row.at("controller").get<std::string>(), row.at("outcomes"));
  if (r.verb == "sweep" && !rows.empty())
    for (const Json* best : best_rows(rows, r.json.value("prefer", "")).best)
      add(row_in_words(r.json, *best), best->at("outcomes"));
  if (r.verb == "map") {
    Json sum = Json::object();
    for (const Json& row : rows)
      for (const auto& [outcome, count] : row.at("outcomes").items())
        sum[outcome] = sum.value(outcome, std::size_t{0}) + count.get<std::size_t>();
    add("At all points", sum);
  }
  return html + damage_paragraph(r);
}

// A key, and what it is.
void add_assumed(const std::string& key, const std::string& value, HtmlTable& table) {
  const SceneKey* known = find_scene_key(key);
  table.row({"<code>" + escaped(key) + "</code>", escaped(value + " " + in_words(key).unit),
             known ? escaped(about(*known)) : ""});
}

// The keys of a document, but for those that were varied.
void add_assumptions(const Json& value, const std::string& key, const Varied& varied,
                     HtmlTable& table) {
  if (varied.contains(key)) return;
  if (value.is_object() && !Distribution::read(value)) {
    for (const auto& [name, part] : value.items())
      add_assumptions(part, key + "." + name, varied, table);
    return;
  }
  if (!value.is_null()) add_assumed(key, setting_text(value), table);
}

std::string assumed_section(const Json& scene, const Varied& varied) {
  HtmlTable table({{"key", false}, {"value"}, {"what it is", false}});
  if (!varied.empty()) table.title("Varied");
  for (const auto& [key, values] : varied) add_assumed(key, values, table);
  if (!varied.empty()) table.title("Assumed");
  for (const char* section : {"fibre", "ferrule", "start", "limits", "success", "sensor", "hand",
                              "joint", "holder", "laws", "roughness_nm", "scaling"})
    if (scene.contains(section)) add_assumptions(scene[section], section, varied, table);
  std::string html = "<h2>What was assumed</h2>\n";
  html += paragraph("Scene " + scene.value("name", "") + ". " + scene.value("about", ""));
  html += paragraph(
      "A value a..b is drawn anew in each trial, uniformly between the two; a+-b normally, cut at "
      "b, which is three standard deviations.");
  return html + table.html();
}

std::string made_section(const std::vector<Result>& results) {
  std::string html = "<h2>How it was made</h2>\n<pre>";
  for (const Result& r : results)
    html += escaped(r.json["provenance"]["command"].get<std::string>()) + "\n";
  html += "</pre>\n";
  for (const Result& r : results) {
    const Json& p = r.json["provenance"];
    std::string text =
        fmt::format("{}: ferrule {} ({})", r.file, p.value("version", ""), p.value("build", ""));
    for (const auto& [of, seed] : p.at("seeds").items())
      text += fmt::format(", seed of {} {}", of, seed.dump());
    text += ", scene SHA-1 " + p.at("scene").value("sha1", "");
    for (const Json& read : p.at("read"))
      text += fmt::format(", read {} (SHA-1 {})", read.value("file", ""), read.value("sha1", ""));
    html += paragraph(text);
  }
  return html;
}

std::string page(const std::vector<Result>& results) {
  std::string html = html_head("ferrule: report") + answers_section(results);
  for (const Result& r : results) {
    const bool alone = results.size() == 1;
    html += "<h2>" + escaped(alone ? "The picture" : r.answer.question) + "</h2>\n";
    html += picture(r);
    if (const std::string limits = limits_section(r); !limits.empty())
      html += (alone ? "<h2>What limits it</h2>\n" : "") + limits;
  }
  html += joint_section(results);
  std::set<std::pair<std::string, Varied>> scenes;
  for (const Result& r : results) {
    const Json& scene = r.json["provenance"]["scene"];
    if (scenes.emplace(scene.value("sha1", ""), varied_by(r)).second)
      html += assumed_section(scene.at("document"), varied_by(r));
  }
  return html + made_section(results) + "</body></html>\n";
}

// By a browser of the Chromium family, headless.
void print_pdf(const std::string& html, const std::string& pdf) {
  const std::string part = pdf + ".part";
  const auto url = "file://" + std::filesystem::absolute(html).string();
  for (const char* browser : {"chromium", "chromium-browser", "google-chrome"}) {
    std::vector<std::string> words = {browser,
                                      "--headless",
                                      "--disable-gpu",
                                      "--no-pdf-header-footer",
                                      "--print-to-pdf-no-header",
                                      "--print-to-pdf=" + std::filesystem::absolute(part).string(),
                                      url};
    if (::geteuid() == 0) words.insert(words.begin() + 1, "--no-sandbox");
    const int status = ChildProcess({}, [&] { execute(words, -1, -1, -1); }).wait();
    std::error_code error;
    if (status == 0 && std::filesystem::file_size(part, error) > 0 && !error) {
      std::filesystem::rename(part, pdf);
      fmt::print(stderr, "wrote {}\n", printable(pdf));
      return;
    }
    std::filesystem::remove(part, error);
  }
  throw FileTrouble(printable(pdf) + ": cannot be printed: is a browser (chromium) installed?");
}

int report_verb(const ReportArguments& a) {
  expect_place_for(a.out);
  expect_place_for(a.pdf);
  std::vector<Result> results;
  for (const std::string& file : a.results) results.push_back(read_result(file, a.prefer));
  if (const bool any = std::any_of(results.begin(), results.end(), is_choice);
      !any && (!a.prefer.prefer.empty() || !a.prefer.prices.empty()))
    throw BadInput("--prefer, --price: need a result of sweep or compare");
  std::string html;
  try {
    html = page(results);
  } catch (const Json::exception& error) {
    throw BadInput(fmt::format("{}: is not whole as it was written: {}",
                               printable(a.results.front()), error.what()));
  }
  write_text(a.out, html);
  fmt::print(stderr, "wrote {}\n", printable(a.out));
  for (const Result& r : results) {
    fmt::print("{}\n", printable(r.answer.question, 1000));
    for (const std::string& line : r.answer.lines) fmt::print("  {}\n", printable(line, 1000));
  }
  std::fflush(stdout);  // before what may fail
  if (!a.pdf.empty()) print_pdf(a.out, a.pdf);
  return kDone;
}

}  // namespace

void add_report(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand(
      "report", "A page for those who decide: question, answer, picture, what was assumed");
  auto a = std::make_shared<ReportArguments>();
  verb->add_option("results", a->results,
                   "What evaluate, compare, sweep, map or sensitivity wrote with --json")
      ->type_name("FILE.json")
      ->required();
  verb->add_option("--out", a->out, "The page")->type_name("FILE.html")->capture_default_str();
  verb->add_option("--pdf", a->pdf, "The page printed, too; needs chromium")->type_name("FILE.pdf");
  a->prefer.add_to(*verb);
  add_examples(*verb, {"report map.json --out map.html", "report sweep.json --prefer loss",
                       "report sweep.json sensitivity.json --pdf report.pdf"});
  verb->callback([a, &run] { run.verb = [a] { return report_verb(*a); }; });
}

}  // namespace ferrule
