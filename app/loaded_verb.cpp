#include "app/loaded_verb.hpp"

#include "learn/loaded_library.hpp"

namespace ferrule {

void add_loaded_verb(CLI::App& app, Run& run, const std::string& name,
                     const std::string& description) {
  CLI::App* verb = app.add_subcommand(name, description);
  verb->preparse_callback([verb, name, &run](std::size_t) {
    const std::string target = "ferrule_" + name + "_verb";
    const auto add_options = *static_cast<const AddOptions*>(loaded_symbol(
        target + ".so", "ferrule_loaded_verb", name + ": build the target " + target + ", too"));
    add_options(*verb, run);
  });
}

}  // namespace ferrule
