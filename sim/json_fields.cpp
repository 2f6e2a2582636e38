#include "sim/json_fields.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace ferrule {
namespace {

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
}  // namespace rule

Json parse_json(const std::string& text, const std::string& file) {
  try {
    return Json::parse(text);
  } catch (const Json::exception& error) {
    std::string reason =
        error.what();  // "[json.exception...] parse error at line 3, column 7: ..."
    if (const auto bracket = reason.find("] "); bracket != std::string::npos)
      reason = reason.substr(bracket + 2);
    for (char& c : reason)
      if (c == '\n') c = ' ';
    throw BadInput(file + ": not valid JSON: " + reason);
  }
}

std::string read_text(const std::string& file) {
  if (std::filesystem::is_directory(file)) throw FileTrouble(file + ": is a directory");
  std::ifstream in(file, std::ios::binary);
  if (!in) throw FileTrouble(file + ": cannot be read: " + std::strerror(errno));
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad()) throw FileTrouble(file + ": cannot be read");
  return text.str();
}

void write_text(const std::string& file, const std::string& text) {
  const std::string beside = file + ".tmp";
  const auto give_up = [&](int error) {
    std::error_code ignored;
    std::filesystem::remove(beside, ignored);
    throw FileTrouble(file + ": cannot be written: " + std::strerror(error));
  };
  const int fd = ::open(beside.c_str(), O_CREAT | O_TRUNC | O_WRONLY | O_CLOEXEC, 0644);
  if (fd < 0) throw FileTrouble(file + ": cannot be written: " + std::strerror(errno));
  for (std::size_t done = 0; done < text.size();) {
    const ssize_t n = ::write(fd, text.data() + done, text.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) {
      const int error = errno;
      ::close(fd);
      give_up(error);
    }
    done += static_cast<std::size_t>(n);
  }
  const int synced = ::fsync(fd) == 0 ? 0 : errno;
  const int closed = ::close(fd) == 0 ? 0 : errno;
  if (synced && synced != EINVAL && synced != EROFS) give_up(synced);
  if (closed) give_up(closed);
  if (::rename(beside.c_str(), file.c_str()) != 0) give_up(errno);
}

JsonFields::JsonFields(const Json& object, std::string file, std::string path)
    : object_(object), file_(std::move(file)), path_(std::move(path)) {
  if (!object_.is_object())
    throw BadInput(file_ + ": " + (path_.empty() ? "the document" : path_) + " = " +
                   shown(object_) + ": must be an object {...}");
}

void JsonFields::refuse(const std::string& key, const std::string& rule) const {
  const auto found = object_.find(key);
  const std::string place = path_.empty() ? key : path_ + "." + key;
  throw BadInput(file_ + ": " + place +
                 (found == object_.end() ? " is missing: " : " = " + shown(*found) + ": ") + rule);
}

const Json& JsonFields::get(const std::string& key, const std::string& expected) {
  known_.insert(key);
  const auto found = object_.find(key);
  if (found == object_.end()) refuse(key, expected);
  return *found;
}

double JsonFields::number(const std::string& key, const Rule& rule) {
  const std::string expected = rule.text;
  const Json& value = get(key, "a number that " + expected);
  if (!value.is_number()) refuse(key, "must be a number");
  const double x = value.get<double>();
  const bool low_ok = rule.low_open ? x > rule.low : x >= rule.low;
  const bool high_ok = rule.high_open ? x < rule.high : x <= rule.high;
  if (!(low_ok && high_ok)) refuse(key, expected);
  return x;
}

std::int64_t JsonFields::integer(const std::string& key, std::int64_t low, std::int64_t high) {
  const std::string expected =
      "must be a whole number from " + std::to_string(low) + " to " + std::to_string(high);
  const Json& value = get(key, expected);
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX) refuse(key, expected);
  if (!value.is_number_integer() || value.get<std::int64_t>() < low ||
      value.get<std::int64_t>() > high)
    refuse(key, expected);
  return value.get<std::int64_t>();
}

Eigen::Vector2d JsonFields::pair(const std::string& key) {
  const Json& value = get(key, "two numbers [a, b]");
  if (!value.is_array() || value.size() != 2 || !value[0].is_number() || !value[1].is_number())
    refuse(key, "must be two numbers [a, b]");
  return {value[0].get<double>(), value[1].get<double>()};
}

std::string JsonFields::text(const std::string& key) {
  const Json& value = get(key, "a text");
  if (!value.is_string()) refuse(key, "must be a text");
  return value.get<std::string>();
}

std::size_t JsonFields::choice(const std::string& key, const std::vector<std::string>& choices) {
  std::string rule = "must be one of";
  for (const auto& each : choices) rule += " \"" + each + "\"";
  const Json& value = get(key, rule);
  for (std::size_t i = 0; i < choices.size(); ++i)
    if (value == choices[i]) return i;
  refuse(key, rule);
}

JsonFields JsonFields::object(const std::string& key) {
  return {get(key, "an object {...}"), file_, path_.empty() ? key : path_ + "." + key};
}

const Json& JsonFields::raw(const std::string& key) {
  return get(key, "a value");
}

bool JsonFields::has(const std::string& key) {
  known_.insert(key);
  const auto found = object_.find(key);
  return found != object_.end() && !found->is_null();
}

void JsonFields::finish() const {
  for (const auto& [key, value] : object_.items())
    if (!known_.count(key)) {
      std::string rule = "unknown key; known here:";
      for (const auto& known : known_) rule += " " + known;
      refuse(key, rule);
    }
}

}  // namespace ferrule
