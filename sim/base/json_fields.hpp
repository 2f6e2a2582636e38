// Reading a JSON object strictly: every key is asked for with its rule, unknown keys are refused.
// Each error is a BadInput of one line: file: key = value: rule. Where a file was read,
// json_file.hpp adds the line.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "sim/base/error.hpp"

namespace ferrule {

using Json = nlohmann::json;

// Text -> JSON. Throws BadInput naming `file` and the line.
Json parse_json(const std::string& text, const std::string& file);
// The line of text[position], from 1.
std::size_t line_at(const std::string& text, std::size_t position);
// Where a dotted key is, "fibre.diameter_um" at /fibre/diameter_um.
Json::json_pointer pointer_to(const std::string& dotted_key);
// A number, or null where it is not finite.
Json number_or_null(double x);
// Throws FileTrouble if the file cannot be read.
std::string read_text(const std::string& file);
std::ifstream open_file(const std::string& file);
// Writes beside `file` and renames when whole; a link is followed, a device or pipe written to.
// With `replace` false an existing file is left alone. Throws FileTrouble.
void write_text(const std::string& file, const std::string& text, bool replace = true);

// Writes all bytes to an open file; returns 0 or errno.
int write_all(int fd, const char* bytes, std::size_t size);

// What a number must be.
struct Rule {
  double low, high;
  bool low_open = false, high_open = false;
  std::string text;  // "must be positive"
  bool whole = false;

  bool allows(double x) const noexcept {
    return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high) &&
           (!whole || x == std::round(x));
  }
};
namespace rule {
Rule any();
Rule positive();
Rule not_negative();
Rule between(double low, double high, std::string text);
// The same with the range in the text: "must be positive, from 1 to 10".
Rule positive(double low, double high);
Rule not_negative(double high);
}  // namespace rule

// A key of a document that is refused, or that is missing.
struct RefusedKey : BadInput {
  RefusedKey(const std::string& in, Json::json_pointer key, const std::string& reason)
      : BadInput(in + ": " + reason), file(in), at(std::move(key)), why(reason) {}

  std::string file;
  Json::json_pointer at;
  std::string why;                                                 // what() without the file
  enum class Kind { wrong, unknown, missing } kind = Kind::wrong;  // unknown: nobody asked for it
  Json value{};                    // that was refused; null of one that is missing
  std::vector<Json> would_do{};    // of one that is missing: values that are allowed
  std::vector<RefusedKey> more{};  // of one that is unknown: others of the same object, 19 at most
};

class JsonFields {
 public:
  // `object` must outlive this. Throws BadInput if it is not an object.
  JsonFields(const Json& object, std::string file);

  double number(const std::string& key, const Rule& rule);
  // NaN where there is none, or null.
  double number_or_nan(const std::string& key, const Rule& rule);
  std::int64_t integer(const std::string& key, std::int64_t low, std::int64_t high);
  bool flag(const std::string& key);
  // [a, b], two finite numbers.
  Eigen::Vector2d pair(const std::string& key);
  std::string text(const std::string& key);
  // A text that can be shown in a line: no control characters, at most `most` characters (UTF-8).
  std::string line(const std::string& key, std::size_t most);
  // One of `choices`; returns its index.
  std::size_t choice(const std::string& key, const std::vector<std::string>& choices);
  JsonFields object(const std::string& key);
  // The object number `index` of the list at `key`, which has as many.
  JsonFields object(const std::string& key, std::size_t index);
  const Json& raw(const std::string& key);
  // Is the key there?
  bool present(const std::string& key);
  // Is it there with a value other than null?
  bool has(const std::string& key);
  // Refuses a key that is there where none of `others` is: without them it does nothing.
  void depends(const std::string& key, const std::vector<std::string>& others);
  // The dotted name of the key in the whole document.
  std::string path(const std::string& key) const;
  // To be called last: throws BadInput on the first key that nobody asked for.
  void finish() const;

  [[noreturn]] void refuse(const std::string& key, const std::string& rule) const;

 private:
  JsonFields(const Json& object, std::string file, Json::json_pointer at);
  RefusedKey refusal(const std::string& key, const std::string& rule) const;
  // Throws where it is missing; `would_do` are values that are allowed, where they are known.
  const Json& get(const std::string& key, const std::string& expected,
                  std::vector<Json> would_do = {});

  const Json& object_;
  std::string file_;
  Json::json_pointer at_;
  std::set<std::string> known_;
};

}  // namespace ferrule
