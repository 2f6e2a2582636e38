#include "controller/controller_file.hpp"

#include <algorithm>
#include <iterator>

#include "controller/baseline.hpp"
#include "sim/base/json_file.hpp"
#include "sim/base/shipped_files.hpp"

namespace ferrule {
namespace {

// Each kind of controller by its name in files.
struct Kind {
  const char* method;
  ControllerFile (*parse)(const Json& json, const std::string& file);
};
template <auto parse>
ControllerFile parsed(const Json& json, const std::string& file) {
  return parse(json, file);
}
constexpr ShippedFiles kControllers = {"controllers", "controller file", "controller"};
constexpr Kind kKinds[] = {{"ceres", parsed<parse_law>},
                           {"torch", parsed<parse_policy>},
                           {"search", parsed<parse_search>}};
static_assert(std::size(kKinds) == std::variant_size_v<ControllerFile>);

}  // namespace

std::string controller_file(const std::string& name_or_file) {
  const std::vector<std::string> shipped = kControllers.names();
  const bool one = std::find(shipped.begin(), shipped.end(), name_or_file) != shipped.end();
  return one ? kControllers.find(name_or_file) : name_or_file;
}

void write_controller(const std::string& file, const ControllerFile& controller) {
  std::visit([&](const auto& c) { write_controller(file, c); }, controller);
}

ControllerFile read_controller(const std::string& name_or_file) {
  const std::string file = kControllers.find(name_or_file, baseline_names());
  std::vector<std::string> methods;
  for (const Kind& kind : kKinds) methods.push_back(kind.method);
  return read_json(file, [&](const Json& json) {
    return kKinds[JsonFields(json, file).choice("method", methods)].parse(json, file);
  });
}

MakeController maker(const ControllerFile& controller) {
  return std::visit([](const auto& c) { return c.maker(); }, controller);
}

const TrainedOn& trained_on(const ControllerFile& controller) {
  return std::visit([](const auto& c) -> const TrainedOn& { return c.trained_on; }, controller);
}

MakeController load_controller(const std::string& name_or_file) {
  return maker(read_controller(name_or_file));
}

}  // namespace ferrule
