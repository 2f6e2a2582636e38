#include "view/page.hpp"

#include <filesystem>
#include <fstream>

#include "sim/error.hpp"
#include "sim/scene/data_folder.hpp"

namespace ferrule {

const char* const kNoPage =
    "the page of the window was not built, because Node was missing: install nodejs and npm, then "
    "build again";

std::optional<std::string> page_html() {
  std::error_code error;
  for (const std::string& file : {std::string(FERRULE_PAGE_BUILT), data_folder() + "/page.html"}) {
    if (!std::filesystem::exists(file, error)) continue;
    std::ifstream in(file, std::ios::binary);
    std::string html((std::istreambuf_iterator<char>(in)), {});
    if (!in || html.empty()) throw FileTrouble(file + ": cannot be read");
    return html;
  }
  return std::nullopt;
}

std::string self_contained(const std::string& page, const Json& recorded) {
  static const std::string element = "<script type=\"application/json\" id=\"recorded\">";
  const std::size_t at = page.rfind(element);
  if (at == page.npos) throw FileTrouble("the page of the window is not of this program");
  std::string json;
  // Within a script element only `<` could end it or begin another.
  for (const char c : recorded.dump(-1, ' ', false, Json::error_handler_t::replace))
    if (c == '<')
      json += "\\u003c";
    else
      json += c;
  std::string html = page;
  return html.insert(at + element.size(), json);
}

}  // namespace ferrule
