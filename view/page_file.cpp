#include "view/page_file.hpp"

#include <filesystem>

#include "sim/scene/data_folder.hpp"
#include "sim/scene/json_fields.hpp"

namespace ferrule {

namespace fs = std::filesystem;

std::string load_page() {
  std::error_code error;
  fs::path file = fs::path(data_folder()) / "page.html";
  if (!fs::exists(file, error)) file = FERRULE_PAGE_BUILT;
  if (!fs::exists(file, error))
    throw BadInput(
        "this program was built without the page of the window: install the packages nodejs and "
        "npm, configure with CMake again and build");
  return read_text(file.string());
}

}  // namespace ferrule
