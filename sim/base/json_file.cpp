#include "sim/base/json_file.hpp"

#include <algorithm>
#include <sstream>
#include <utility>

namespace ferrule {
namespace {

// 0: it is not there, or within a list.
std::size_t line_of(const Json::json_pointer& key, const std::string& text) {
  std::istringstream in(text);
  std::vector<std::string> path;  // to what is read; empty texts for lists
  std::size_t line = 0;
  const auto watch = [&](int depth, Json::parse_event_t event, Json& value) {
    if (event != Json::parse_event_t::key || line > 0) return true;
    path.resize(static_cast<std::size_t>(depth));
    path.back() = value;
    Json::json_pointer here;
    for (const std::string& part : path) here /= part;
    if (here == key) line = line_at(text, static_cast<std::size_t>(in.tellg()));
    return true;
  };
  [[maybe_unused]] const Json whole = Json::parse(in, watch);
  return line;
}

// Keys that `read` does not know in `document`, whatever the values of those that are missing: they
// are filled in for a while. At most `left` readings.
std::vector<RefusedKey> unknown_besides(Json& document, const std::string& file,
                                        const std::function<void(const Json&)>& read, int& left) {
  if (left-- == 0) return {};
  try {
    read(document);
  } catch (const RefusedKey& refused) {
    if (refused.file != file || refused.kind == RefusedKey::Kind::wrong) return {};
    std::vector<RefusedKey> found = refused.more;
    if (refused.kind == RefusedKey::Kind::unknown) found.insert(found.begin(), refused);
    bool first = true;
    for (const Json& value : refused.would_do) {
      document[refused.at] = value;
      const std::vector<RefusedKey> these = unknown_besides(document, file, read, left);
      document[refused.at.parent_pointer()].erase(refused.at.back());
      if (std::exchange(first, false)) found = these;
      std::erase_if(found, [&](const RefusedKey& f) {
        return std::none_of(these.begin(), these.end(),
                            [&](const RefusedKey& other) { return other.at == f.at; });
      });
      if (found.empty()) break;
    }
    return found;
  } catch (const std::exception&) {
    return {};
  }
  return {};
}

}  // namespace

void refuse_with_line(const RefusedKey& refused, const Json& document, const std::string& text,
                      const std::function<void(const Json&)>& read) {
  int left = 200;
  RefusedKey shown = refused;
  if (refused.kind == RefusedKey::Kind::missing) {
    Json filled = document;
    const std::vector<RefusedKey> unknown = unknown_besides(filled, refused.file, read, left);
    if (!unknown.empty()) shown = unknown.front();
  }
  const bool there = document.contains(shown.at) && document.at(shown.at) == shown.value;
  const std::size_t line = there ? line_of(shown.at, text) : 0;
  if (line > 0) shown = {shown.file, shown.at, "line " + std::to_string(line) + ": " + shown.why};
  throw shown;
}

}  // namespace ferrule
