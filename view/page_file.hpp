// The page that the window shows, one HTML file that the build makes of view/page/.
#pragma once

#include <string>

namespace ferrule {

// The text of page.html: of the share folder that the program was installed to, or else of the
// build. Throws BadInput where it was never built.
std::string load_page();

}  // namespace ferrule
