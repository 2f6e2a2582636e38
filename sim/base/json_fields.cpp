#include "sim/base/json_fields.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "sim/base/unknown_name.hpp"
#include "sim/base/written_file.hpp"

namespace ferrule {
namespace {

constexpr int kMostLevels = 32;  // levels of a JSON document; what prints one needs stack for each

// As messages name it: "trained_on.episodes[1].file".
std::string dotted(Json::json_pointer at) {
  std::string text;
  for (; !at.empty(); at.pop_back()) {
    const std::string& part = at.back();
    const bool index = part.find_first_not_of("0123456789") == part.npos;
    text = (index ? "[" + part + "]" : "." + part) + text;
  }
  return text.starts_with('.') ? text.substr(1) : text;
}

// The text of a value in a message: one line, cut where it is long.
std::string shown(const Json& value) {
  std::string text = value.dump(-1, ' ', false, Json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

}  // namespace

namespace rule {
Rule any() {
  return {-INFINITY, INFINITY, true, true, "must be a finite number"};
}
Rule positive() {
  return {0, INFINITY, true, true, "must be positive"};
}
Rule not_negative() {
  return {0, INFINITY, false, true, "must not be negative"};
}
Rule between(double low, double high, std::string text) {
  return {low, high, false, false, std::move(text)};
}

namespace {
Rule with_range(double low, double high, const char* must_be) {
  std::ostringstream text;
  text << must_be << ", from " << low << " to " << high;
  return between(low, high, text.str());
}
}  // namespace

Rule positive(double low, double high) {
  return with_range(low, high, "must be positive");
}
Rule not_negative(double high) {
  return with_range(0, high, "must not be negative");
}
}  // namespace rule

std::size_t line_at(const std::string& text, std::size_t position) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(position, text.size()));
  return 1 + static_cast<std::size_t>(std::count(text.begin(), end, '\n'));
}

namespace {

// Does a comment of another language begin with the byte of that number, counted from 1?
bool begins_comment(const std::string& text, std::size_t byte) {
  const std::string two = byte > 0 && byte <= text.size() ? text.substr(byte - 1, 2) : "";
  return two == "//" || two == "/*" || two.starts_with('#');
}

// What Windows calls Unicode: with a mark in front, or a zero beside the first letter.
bool is_utf16(const std::string& text) {
  return text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff") ||
         text.substr(0, 2).find('\0') != text.npos;
}

}  // namespace

Json parse_json(const std::string& text, const std::string& file) {
  if (is_utf16(text)) throw BadInput(file + ": is UTF-16 or UTF-32: save it as UTF-8");
  std::vector<std::set<std::string>> open;  // keys of the objects that are being read
  std::string twice;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& value) {
    if (depth > kMostLevels) throw BadInput(file + ": nested deeper than any document read here");
    if (event == Json::parse_event_t::object_start) open.emplace_back();
    if (event == Json::parse_event_t::object_end) open.pop_back();
    if (event == Json::parse_event_t::key && !open.back().insert(value).second)
      twice = shown(value);
    return true;
  };
  try {
    Json json = Json::parse(text, watch);
    if (!twice.empty()) throw BadInput(file + ": the key " + twice + " is there twice");
    return json;
  } catch (const Json::exception& error) {
    const auto* broken = dynamic_cast<const Json::parse_error*>(&error);
    if (broken && begins_comment(text, broken->byte))
      throw BadInput(file + ": line " + std::to_string(line_at(text, broken->byte)) +
                     ": JSON has no comments");
    std::string reason =
        error.what();  // "[json.exception...] parse error at line 3, column 7: ..."
    if (broken && reason.find("ill-formed UTF-8") != reason.npos)
      throw BadInput(file + ": line " + std::to_string(line_at(text, broken->byte)) +
                     ": is not UTF-8: save it as UTF-8");
    if (const auto bracket = reason.find("] "); bracket != std::string::npos)
      reason = reason.substr(bracket + 2);
    for (char& c : reason)
      if (c == '\n') c = ' ';
    throw BadInput(file + ": not valid JSON: " + reason);
  }
}

std::ifstream open_file(const std::string& file) {
  std::error_code error;  // says no more than opening it will
  const std::filesystem::file_status there = std::filesystem::status(file, error);
  if (std::filesystem::is_directory(there)) throw FileTrouble(file + ": is a directory");
  if (std::filesystem::exists(there) && !std::filesystem::is_regular_file(there))
    throw FileTrouble(file + ": is a device or a pipe, not a file");  // some never end
  std::ifstream in(file, std::ios::binary);
  if (!in) throw FileTrouble(file + ": cannot be read: " + std::strerror(errno));
  return in;
}

std::string read_text(const std::string& file) {
  const std::ifstream in = open_file(file);
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad() || text.bad()) throw FileTrouble(file + ": cannot be read");
  return text.str();
}

int write_all(int fd, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t n = ::write(fd, bytes, size);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    bytes += n;
    size -= static_cast<std::size_t>(n);
  }
  return 0;
}

Json::json_pointer pointer_to(const std::string& dotted_key) {
  Json::json_pointer at;
  std::istringstream parts(dotted_key);
  for (std::string part; std::getline(parts, part, '.');) at /= part;
  return at;
}

Json number_or_null(double x) {
  return std::isfinite(x) ? Json(x) : Json(nullptr);
}

void write_text(const std::string& name, const std::string& text, bool replace) {
  WrittenFile(name, text).commit(replace);
}

JsonFields::JsonFields(const Json& object, std::string file)
    : JsonFields(object, std::move(file), Json::json_pointer()) {}

JsonFields::JsonFields(const Json& object, std::string file, Json::json_pointer at)
    : object_(object), file_(std::move(file)), at_(std::move(at)) {
  if (object_.is_object()) return;
  RefusedKey refused(file_, at_,
                     (at_.empty() ? "the document" : dotted(at_)) + " = " + shown(object_) +
                         ": must be an object {...}");
  refused.value = object_;
  throw refused;
}

RefusedKey JsonFields::refusal(const std::string& key, const std::string& rule) const {
  const auto found = object_.find(key);
  const bool missing = found == object_.end();
  RefusedKey refused(
      file_, at_ / key,
      dotted(at_ / key) + (missing ? " is missing: " : " = " + shown(*found) + ": ") + rule);
  if (missing)
    refused.kind = RefusedKey::Kind::missing;
  else
    refused.value = *found;
  return refused;
}

void JsonFields::refuse(const std::string& key, const std::string& rule) const {
  throw refusal(key, rule);
}

const Json& JsonFields::get(const std::string& key, const std::string& expected,
                            std::vector<Json> would_do) {
  known_.insert(key);
  const auto found = object_.find(key);
  if (found != object_.end()) return *found;
  RefusedKey missing = refusal(key, expected);
  missing.would_do = std::move(would_do);
  throw missing;
}

double JsonFields::number_or_nan(const std::string& key, const Rule& rule) {
  return has(key) ? number(key, rule) : std::numeric_limits<double>::quiet_NaN();
}

double JsonFields::number(const std::string& key, const Rule& rule) {
  const std::string expected = rule.text;
  const double would_do = rule.allows(1) ? 1 : rule.low + (rule.high - rule.low) / 2;
  const Json& value = get(key, "a number that " + expected, {would_do});
  if (!value.is_number()) refuse(key, "must be a number");
  const double x = value.get<double>();
  if (!rule.allows(x)) refuse(key, expected);
  return x;
}

std::int64_t JsonFields::integer(const std::string& key, std::int64_t low, std::int64_t high) {
  const std::string expected =
      "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const Json& value = get(key, expected, {low});
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX) refuse(key, expected);
  if (!value.is_number_integer() || value.get<std::int64_t>() < low ||
      value.get<std::int64_t>() > high)
    refuse(key, expected);
  return value.get<std::int64_t>();
}

Eigen::Vector2d JsonFields::pair(const std::string& key) {
  const Json& value = get(key, "two numbers [a, b]", {Json{1, 1}});
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    refuse(key, "must be two numbers [a, b]");
  return {value[0].get<double>(), value[1].get<double>()};
}

std::string JsonFields::text(const std::string& key) {
  const Json& value = get(key, "a text", {""});
  if (!value.is_string()) refuse(key, "must be a text");
  return value.get<std::string>();
}

bool JsonFields::flag(const std::string& key) {
  const Json& value = get(key, "must be true or false");
  if (!value.is_boolean()) refuse(key, "must be true or false");
  return value;
}

std::string JsonFields::line(const std::string& key, std::size_t most) {
  std::string shown = text(key);
  const auto characters =
      std::count_if(shown.begin(), shown.end(), [](char c) { return (c & 0xC0) != 0x80; });
  if (std::any_of(shown.begin(), shown.end(),
                  [](char c) { return (c >= 0 && c < 0x20) || c == 0x7f; }) ||
      static_cast<std::size_t>(characters) > most)
    refuse(key, "must be one line of at most " + std::to_string(most) + " characters");
  return shown;
}

std::size_t JsonFields::choice(const std::string& key, const std::vector<std::string>& choices) {
  std::string rule = "must be one of";
  for (const auto& each : choices) rule += " \"" + each + "\"";
  const Json& value = get(key, rule, std::vector<Json>(choices.begin(), choices.end()));
  for (std::size_t i = 0; i < choices.size(); ++i)
    if (value == choices[i]) return i;
  refuse(key, rule);
}

JsonFields JsonFields::object(const std::string& key) {
  return {get(key, "an object {...}", {Json::object()}), file_, at_ / key};
}

JsonFields JsonFields::object(const std::string& key, std::size_t index) {
  return {get(key, "a list").at(index), file_, at_ / key / index};
}

const Json& JsonFields::raw(const std::string& key) {
  return get(key, "a value");
}

bool JsonFields::present(const std::string& key) {
  known_.insert(key);
  return object_.contains(key);
}

bool JsonFields::has(const std::string& key) {
  known_.insert(key);
  const auto found = object_.find(key);
  return found != object_.end() && !found->is_null();
}

void JsonFields::depends(const std::string& key, const std::vector<std::string>& others) {
  if (!present(key) ||
      std::any_of(others.begin(), others.end(), [&](const auto& other) { return present(other); }))
    return;
  std::string names;
  for (const std::string& other : others) names += (names.empty() ? "" : " or ") + other;
  refuse(key, "does nothing without " + names);
}

std::string JsonFields::path(const std::string& key) const {
  return dotted(at_ / key);
}

void JsonFields::finish() const {
  const std::vector<std::string> known(known_.begin(), known_.end());
  constexpr std::size_t kMostNamed = 20;
  std::vector<RefusedKey> all;
  for (const auto& [key, value] : object_.items()) {
    if (known_.count(key) || all.size() == kMostNamed) continue;
    const std::string meant = nearest(key, known);
    std::string rule = "unknown key; known here:";
    for (const std::string& each : known) rule += " " + each;
    if (!meant.empty()) rule = unknown_key(dotted(at_ / key), value, dotted(at_ / meant));
    all.push_back(refusal(key, rule));
    all.back().kind = RefusedKey::Kind::unknown;
  }
  if (all.empty()) return;
  RefusedKey first = all.front();
  first.more.assign(all.begin() + 1, all.end());
  throw first;
}

}  // namespace ferrule
