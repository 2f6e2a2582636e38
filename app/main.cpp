#include <fmt/format.h>

#include <iostream>

#include "app/verb.hpp"
#include "capture/episode.hpp"
#include "haptic/trouble.hpp"

int main(int argc, char** argv) {
  using namespace ferrule;
  CLI::App app("Simulate, record and learn the insertion of an optical fibre into a ferrule.",
               "ferrule");
  app.set_version_flag("--version", program_version() + " (" + program_build() + ")");
  app.require_subcommand(1);
  Run run;
  add_demo(app, run);
  add_forces(app, run);
  add_contact(app, run);
  add_plan(app, run);
  add_record(app, run);
  add_recover(app, run);
  add_replay(app, run);
  add_score(app, run);
  add_fit(app, run);
  add_identify(app, run);
  add_evaluate(app, run);
  add_compare(app, run);
  add_export(app, run);
  add_bench(app, run);
  add_devices(app, run);
  add_doctor(app, run);
  const auto is_verb = [&](const std::string& word) {
    for (const CLI::App* verb : app.get_subcommands({}))
      if (verb->get_name() == word) return true;
    return false;
  };
  if (argc > 1 && argv[1][0] != '-' && !is_verb(argv[1])) {
    fmt::print(stderr, "ferrule: unknown verb \"{}\" (see ferrule --help)\n", argv[1]);
    return kBadInput;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    return app.exit(asked);
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "ferrule: {} (see ferrule --help)\n", error.what());
    return kBadInput;
  }
  try {
    const int code = run();
    std::cout.flush();
    if (!std::cout || std::fflush(stdout) != 0 || std::ferror(stdout)) {
      fmt::print(stderr, "ferrule: standard output cannot be written\n");
      return kFileTrouble;
    }
    return code;
  } catch (const BadInput& error) {
    fmt::print(stderr, "ferrule: {}\n", error.what());
    return kBadInput;
  } catch (const FileTrouble& error) {
    fmt::print(stderr, "ferrule: {}\n", error.what());
    return kFileTrouble;
  } catch (const DeviceTrouble& trouble) {
    fmt::print(stderr, "ferrule: {}\n", trouble.what());
    return kDeviceTrouble;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "ferrule: out of memory\n");
    return kFileTrouble;
  } catch (const std::exception& error) {
    fmt::print(stderr, "ferrule: {}\n", error.what());
    return kFileTrouble;
  }
}
