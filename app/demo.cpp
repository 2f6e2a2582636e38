#include "app/verb.hpp"
namespace ferrule {
void add_demo(CLI::App&, Run&) {}
}  // namespace ferrule
