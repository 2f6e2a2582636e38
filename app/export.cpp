// ferrule export: a controller in a form that others run.
#include <fmt/format.h>

#include "app/given_controller.hpp"
#include "app/output.hpp"
#include "app/verbs.hpp"
#include "controller/c_header.hpp"
#include "learn/torch_policy.hpp"
#include "sim/base/written_file.hpp"

namespace ferrule {
namespace {

struct ExportArguments {
  std::string controller, torchscript, header;
  bool json = false;
};

int export_verb(const ExportArguments& a) {
  if (a.torchscript.empty() && a.header.empty())
    throw BadInput("export: give --torchscript FILE.pt, or --header FILE.h, or both");
  const ControllerFile controller = own_controller(
      a.controller, "is not learned here; what is exported is a law, a search or a network");
  std::string script;
  if (!a.torchscript.empty()) {
    const auto* policy = std::get_if<PolicyFile>(&controller);
    if (!policy)
      throw BadInput(a.controller +
                     ": is no network: --torchscript needs a controller of method torch");
    script = torchscript_bytes(policy->policy);
  }
  const std::string header = c_header(controller, a.controller);
  Json written = Json::array();
  std::vector<std::unique_ptr<WrittenFile>> files;  // all of them get their names, or none
  using Output = std::pair<const std::string&, const std::string&>;
  for (const auto& [file, text] : {Output(a.torchscript, script), Output(a.header, header)}) {
    if (file.empty()) continue;
    files.push_back(std::make_unique<WrittenFile>(file, text));
    written.push_back(file);
  }
  for (const auto& file : files) file->commit();
  Provenance provenance;
  provenance.read(controller_file(a.controller));  // it names its weights by their hash
  if (a.json) {
    print_json({{"controller", a.controller}, {"written", written}}, provenance);
  } else {
    for (const auto& file : written) fmt::print("wrote {}\n", printable(file.get<std::string>()));
    fmt::print("{}", provenance.foot());
  }
  return kDone;
}

}  // namespace

void add_export(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("export", "A controller as TorchScript or as a C header");
  auto a = std::make_shared<ExportArguments>();
  verb->add_option("controller", a->controller, "Controller: a file, or a shipped one")
      ->required()
      ->type_name("FILE.json");
  verb->add_option("--torchscript", a->torchscript, "For torch.jit.load; networks only")
      ->type_name("FILE.pt");
  verb->add_option("--header", a->header, "C99, for a machine's own controller")
      ->type_name("FILE.h");
  verb->add_flag("--json", a->json, "One JSON document on stdout");
  add_examples(*verb, {"export controller.json --header controller.h",
                       "export policy.json --torchscript policy.pt"});
  verb->callback([a, &run] { run.verb = [a] { return export_verb(*a); }; });
}

}  // namespace ferrule
