#include "app/verb.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <thread>

#include "app/csv.hpp"
#include "app/scene_keys.hpp"
#include "controller/controller_file.hpp"
#include "sim/analysis/plan.hpp"
#include "sim/base/elementary.hpp"
#include "sim/base/unknown_name.hpp"
#include "sim/scene/setting.hpp"

namespace ferrule {
namespace {

// What `text` is in decimal, and nothing else; empty: no such number.
template <class Number>
std::optional<Number> decimal(std::string_view text) {
  Number value{};
  if (text.starts_with('+')) text.remove_prefix(1);
  const char* const end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && rest == end ? std::optional(value) : std::nullopt;
}

// CLI11 would read 010 as 8, and 0x10 as 16.
std::optional<std::uint64_t> whole(std::string_view text) {
  const bool octal = text.size() > 1 && text[0] == '0';
  return octal ? std::nullopt : decimal<std::uint64_t>(text);
}

double parse_number(const std::string& text, const std::string& option) {
  const double value = decimal<double>(text).value_or(NAN);
  if (!std::isfinite(value))
    throw BadInput(option + " " + text + ": must be a number or from:to:count[:log]");
  return value;
}

}  // namespace

void SceneArguments::add_to(CLI::App& verb, const std::string& unless_given) {
  verb.add_option("--scene", scene,
                  "Scene: a file, or the name of a shipped one; unless given " + unless_given)
      ->type_name("NAME|FILE");
  verb.add_option("--set", settings, "Change one value of the scene; can be repeated")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

std::string SceneArguments::given() const {
  std::string text = scene.empty() ? "" : " --scene " + scene;
  for (const std::string& setting : settings) text += " --set '" + setting + "'";
  return text;
}

Scene SceneArguments::load() const {
  for (const std::string& setting : settings) refuse_unknown_key(setting);
  return load_scene(name(), settings);
}

namespace {

// Whoever reads no more than stderr is told too.
void note_accuracy(const Json& document) {
  const double bound = document.value("planned_error_bound", 0.0);
  const double accuracy = document.value("planned_accuracy", 0.0);
  if (bound > accuracy)
    fmt::print(stderr,
               "note: accuracy = {:g} is not reached: the error bound of the plan is {:.2g} "
               "(see ferrule plan)\n",
               accuracy, bound);
}

}  // namespace

ChosenScene SceneArguments::choose(const BroughtScene& brought) const {
  ChosenScene chosen;
  const bool brings = !brought.document.is_null();
  if (scene.empty() && (brings || !brought.open.empty())) {
    for (const std::string& setting : settings) refuse_unknown_key(setting);
    if (!brings) throw BadInput(brought.open + "; choose a scene with --scene");
    Json document = brought.document;
    for (const std::string& setting : settings) apply_setting(document, setting);
    const std::string source = "the scene that " + brought.how;
    chosen.scene = parse_scene(document, source);
    if (!settings.empty()) refuse_contradictions(chosen.scene, source);
    chosen.scene = planned_with_progress(chosen.scene);
    note_accuracy(chosen.scene.document);
    chosen.other = !same_scene(document, brought.document);
    chosen.relation = (chosen.other ? ", changed from what " : ", as ") + brought.how;
    return chosen;
  }
  chosen.file = scene_file(name());
  const Scene loaded = load();
  chosen.scene = planned_with_progress(loaded);
  note_accuracy(chosen.scene.document);
  if (!brings) {
    if (!brought.open.empty()) chosen.relation = "; " + brought.open;
    return chosen;
  }
  chosen.other = !same_scene(chosen.scene.document, brought.document) &&
                 !same_scene(loaded.document, brought.document);
  chosen.relation = chosen.other ? ", NOT the scene " + brought.document.value("name", "") +
                                       " that " + brought.how
                                 : ", as " + brought.how;
  return chosen;
}

namespace {

bool is_seed(const std::string& text) {
  const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
  return digits && (text.size() < 19 || (text.size() == 19 && text <= "9223372036854775807"));
}

}  // namespace

void add_plot(CLI::App& verb, std::string& file, const std::string& help) {
  const auto is_svg = [](const std::string& name) {
    const std::string kind = std::filesystem::path(name).extension();
    return kind.empty() || kind == ".svg" ? std::string() : "is drawn as .svg, not " + kind;
  };
  verb.add_option("--plot", file, help)->type_name("FILE.svg")->check(CLI::Validator(is_svg, ""));
}

CLI::Validator seed_rule() {
  return CLI::Validator(
      [](const std::string& text) {
        return is_seed(text) ? std::string()
                             : "must be a whole number from 0 to 2^63 - 1, not " + text;
      },
      "WHOLE");
}

void add_seed(CLI::App& verb, std::uint64_t& seed, const std::string& help, const char* flag) {
  verb.add_option(flag, seed, help)->capture_default_str()->check(seed_rule());
}

CLI::Option* add_skill(CLI::App& verb, OperatorSkill& skill, const std::string& help) {
  const auto read = [&skill](const std::string& text) {
    try {
      skill = OperatorSkill::parse(text);
    } catch (const BadInput& error) {
      throw CLI::ValidationError("--skill", error.what());
    }
  };
  return verb.add_option_function<std::string>("--skill", read, help)
      ->default_str(skill.text())
      ->type_name("0 to 1[,TRAIT=VALUE,...]");
}

void add_seeds(CLI::App& verb, std::string& seeds, const std::string& help) {
  verb.add_option("--seeds", seeds, help)->type_name("FROM..TO|N,N,...");
}

std::vector<std::uint64_t> parse_seeds(const std::string& text) {
  constexpr std::uint64_t kMost = 1000;
  const auto refuse = [&]() {
    return BadInput("--seeds " + text +
                    ": must be FROM..TO or N,N,..., up to 1000 whole numbers from 0 to 2^63 - 1");
  };
  std::vector<std::uint64_t> seeds;
  if (const auto dots = text.find(".."); dots != text.npos) {
    const std::string from = text.substr(0, dots), to = text.substr(dots + 2);
    if (!is_seed(from) || !is_seed(to)) throw refuse();
    const std::uint64_t first = std::stoull(from), last = std::stoull(to);
    if (last < first || last - first >= kMost) throw refuse();
    for (std::uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
    return seeds;
  }
  for (const std::string& part : CLI::detail::split(text, ',')) {
    if (!is_seed(part) || seeds.size() == kMost) throw refuse();
    seeds.push_back(std::stoull(part));
  }
  return seeds;
}

void add_threads(CLI::App& verb, int& threads) {
  constexpr std::uint64_t kMostThreads = 4096;
  const std::uint64_t cores = std::max(1u, std::thread::hardware_concurrency());
  const auto at_most_cores = [cores](std::string& text) {
    const std::uint64_t wanted = whole(text).value_or(0);
    if (wanted > cores && wanted <= kMostThreads) {
      fmt::print(stderr, "note: --threads {}: this machine has {}, which are used\n", wanted,
                 cores);
      text = std::to_string(cores);
    }
    return std::string();
  };
  verb.add_option("--threads", threads, "0: all cores; the result does not depend on it")
      ->capture_default_str()
      ->transform(CLI::Validator(at_most_cores, ""))
      ->check(whole_number(0, kMostThreads));
}

void add_examples(CLI::App& verb, const std::vector<std::string>& examples) {
  std::string text = "Examples:";
  for (const std::string& example : examples) text += "\n  ferrule " + example;
  verb.footer(text);
}

void add_json(CLI::App& verb, bool& json) {
  verb.add_flag("--json", json, "One JSON document on stdout");
}

void add_output(CLI::App& verb, Output& output) {
  auto* json = verb.add_flag("--json", output.json, "One JSON document on stdout");
  verb.add_flag("--csv", output.csv, "The table as CSV on stdout, one line of names first")
      ->excludes(json);
}

void print_result(const Output& output, Json document, const char* table,
                  const Provenance& provenance) {
  if (output.csv) std::cout << csv_text(document.at(table), provenance) << std::flush;
  if (output.json) print_json(std::move(document), provenance);
}

void expect_place_for(const std::string& file) {
  namespace fs = std::filesystem;
  std::error_code error;
  if (file.empty()) return;
  if (fs::is_directory(file, error)) throw FileTrouble(file + ": is a directory");
  const fs::path folder = fs::path(file).parent_path();
  if (!folder.empty() && !fs::is_directory(folder, error))
    throw FileTrouble(file + ": cannot be written: there is no folder " + folder.string());
  // A link is followed, a device or pipe written to, and a file renamed into its folder.
  const fs::path whole = fs::weakly_canonical(fs::absolute(file), error);
  const bool device = fs::exists(whole, error) && !fs::is_regular_file(whole, error);
  const fs::path written = device ? whole : whole.parent_path();
  if (::access(written.c_str(), W_OK) != 0)
    throw FileTrouble(file + ": cannot be written: " + std::strerror(errno));
}

Scene planned_with_progress(const Scene& scene) {
  Progress progress("planning", 1);
  return planned(scene, [&](std::size_t runs, std::size_t most) {
    end_if_interrupted();
    progress(runs, "", most);
    return true;
  });
}

CLI::Validator one_of(const std::vector<std::string>& choices) {
  const std::string all = CLI::detail::generate_set(choices);
  return CLI::Validator(
      [choices, all](const std::string& text) {
        const bool known = std::find(choices.begin(), choices.end(), text) != choices.end();
        return known ? std::string() : text + " not in " + all + did_you_mean(text, choices);
      },
      all);
}

CLI::Validator whole_number(std::uint64_t low, std::uint64_t high) {
  const auto inside = [low, high](const std::string& text) {
    const std::optional<std::uint64_t> value = whole(text);
    return value && *value >= low && *value <= high
               ? std::string()
               : fmt::format("must be a whole number from {} to {}, not {}", low, high, text);
  };
  return CLI::Validator(inside, fmt::format("[{} to {}]", low, high));
}

CLI::Validator number_between(double low, double high) {
  const auto inside = [low, high](const std::string& text) {
    const double value = decimal<double>(text).value_or(NAN);
    return value >= low && value <= high
               ? std::string()
               : fmt::format("must be a number from {} to {}, not {}", low, high, text);
  };
  return CLI::Validator(inside, fmt::format("[{} to {}]", low, high));
}

void print_json(const Json& json) {
  std::string text;
  // DEL and C1, on which terminals act, as JSON may spell them; it spells the others so anyway.
  for (const char c : json.dump(-1, ' ', false, Json::error_handler_t::replace)) {
    const auto byte = static_cast<unsigned char>(c);
    const bool c1 = byte >= 0x80 && byte < 0xa0 && !text.empty() && text.back() == '\xc2';
    if (c1) text.pop_back();
    text += c1 || byte == 0x7f ? fmt::format("\\u{:04x}", byte) : std::string(1, c);
  }
  std::cout << text << std::endl;
}

void print_json(Json json, const Provenance& provenance) {
  json["provenance"] = provenance.to_json();
  print_json(json);
}

std::string number_or(const char* otherwise, const char* format, double x) {
  return std::isfinite(x) ? fmt::format(fmt::runtime(format), x) : std::string(otherwise);
}

std::vector<double> parse_range(const std::string& text, const std::string& option) {
  std::vector<std::string> parts(1);
  for (const char c : text)
    if (c == ':')
      parts.emplace_back();
    else
      parts.back() += c;
  if (parts.size() == 1) return {parse_number(parts[0], option)};
  if (parts.size() < 3 || parts.size() > 4 || (parts.size() == 4 && parts[3] != "log"))
    throw BadInput(option + " " + text + ": must be a number or from:to:count[:log]");
  const double from = parse_number(parts[0], option), to = parse_number(parts[1], option);
  const double count = parse_number(parts[2], option);
  if (count != std::floor(count) || count < 1 || count > 1e6)
    throw BadInput(option + " " + text + ": the count must be a whole number from 1 to 1000000");
  const bool logarithmic = parts.size() == 4;
  if (logarithmic && !(from > 0 && to > 0))
    throw BadInput(option + " " + text + ": both ends of a logarithmic range must be positive");
  if (logarithmic && !(std::isfinite(to / from) && to / from > 0))
    throw BadInput(option + " " + text + ": the ends are too far apart");
  const auto n = static_cast<std::size_t>(count);
  std::vector<double> values(n, from);
  for (std::size_t i = 1; i < n; ++i) {
    const double part = static_cast<double>(i) / static_cast<double>(n - 1);
    values[i] = interpolate(from, to, part, logarithmic);
  }
  if (n > 1) values.back() = to;
  return values;
}

double interpolate(double from, double to, double part, bool logarithmic) {
  return logarithmic ? from * elementary::exp(part * elementary::log(to / from))
                     : from + part * (to - from);
}

}  // namespace ferrule
