#include "view/page_file.hpp"

#include <filesystem>

#include "sim/base/data_folder.hpp"

namespace ferrule {

namespace fs = std::filesystem;

const char* const kNoPage =
    "this program was built without the page of the window: install the packages nodejs and npm, "
    "configure with CMake again and build";

std::optional<std::string> built_page() {
  std::error_code error;
  fs::path file = fs::path(data_folder()) / "page.html";
  if (!fs::exists(file, error)) file = FERRULE_PAGE_BUILT;
  if (!fs::exists(file, error)) return std::nullopt;
  return read_text(file.string());
}

std::string load_page() {
  std::optional<std::string> page = built_page();
  if (!page) throw BadInput(kNoPage);
  return *std::move(page);
}

std::string policy_of(const std::string& page) {
  static const std::string meta = "<meta http-equiv=\"Content-Security-Policy\" content=\"";
  const std::size_t at = page.find(meta), begin = at + meta.size();
  return at == page.npos ? "default-src 'none'" : page.substr(begin, page.find('"', begin) - begin);
}

std::string sources_of(const std::string& page, const std::string& kind) {
  const std::string policy = policy_of(page);
  const std::size_t at = policy.find(kind + ' '), begin = at + kind.size() + 1;
  return at == policy.npos ? "" : policy.substr(begin, policy.find(';', begin) - begin);
}

std::string self_contained(const std::string& page, const Json& recorded) {
  static const std::string element = "<script type=\"application/json\" id=\"recorded\">";
  const std::size_t at = page.rfind(element);
  if (at == page.npos) throw FileTrouble("page.html: not the page of this program");
  std::string json;
  // Within a script element only `<` could end it or begin another.
  for (const char c : recorded.dump(-1, ' ', false, Json::error_handler_t::replace))
    if (c == '<')
      json += "\\u003c";
    else
      json += c;
  return std::string(page).insert(at + element.size(), json);
}

}  // namespace ferrule
