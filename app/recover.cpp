// ferrule recover: episodes whose recording was killed.
#include <fmt/format.h>

#include <algorithm>

#include "app/interrupt.hpp"
#include "app/output.hpp"
#include "app/progress.hpp"
#include "app/verbs.hpp"
#include "capture/recorder.hpp"

namespace ferrule {
namespace {

struct RecoverArguments {
  std::string folder;
  Output output;
};

int recover_verb(const RecoverArguments& a) {
  Progress progress("recovering", 1);
  std::size_t left = 0;  // journals, where Ctrl-C ended it
  const std::vector<Recovered> all = recover(a.folder, [&](std::size_t done, std::size_t of) {
    progress(done, "", of);
    if (interrupted()) left = of - done;
    return !interrupted();
  });
  Json list = Json::array();
  Provenance provenance;
  for (const Recovered& r : all) {
    list.push_back({{"journal", r.journal},
                    {"file", r.file.empty() ? Json(nullptr) : Json(r.file)},
                    {"rows", r.rows},
                    {"outcome", r.file.empty() ? Json(nullptr) : Json(name(r.outcome))},
                    {"remark", r.remark}});
    if (r.damaged) fmt::print(stderr, "{} {}\n", printable(r.journal), printable(r.remark));
    if (!a.output.text()) continue;
    if (!r.file.empty())
      fmt::print("{} -> {}: {} rows, outcome {}\n", printable(r.journal), printable(r.file), r.rows,
                 name(r.outcome));
    else if (!r.damaged)
      fmt::print("{} {}\n", printable(r.journal), printable(r.remark));
  }
  if (left) provenance.partial(fmt::format("{} journals are left as they are", left));
  if (a.output.text() && all.empty()) fmt::print("{}: nothing to recover\n", printable(a.folder));
  if (a.output.text()) fmt::print("{}", provenance.foot());
  print_result(a.output, {{"recovered", list}}, "recovered", provenance);
  if (left) return kInterrupted;
  const bool damaged =
      std::any_of(all.begin(), all.end(), [](const Recovered& r) { return r.damaged; });
  return damaged ? kFileTrouble : kDone;
}

}  // namespace

void add_recover(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("recover", "Bring back episodes whose recording was killed");
  auto a = std::make_shared<RecoverArguments>();
  verb->add_option("folder", a->folder, "Folder with the episodes")->required()->type_name("DIR");
  add_output(*verb, a->output);
  add_examples(*verb, {"recover episodes", "recover episodes --json"});
  verb->callback([a, &run] { run.verb = [a] { return recover_verb(*a); }; });
}

}  // namespace ferrule
