#include "controller/load_controller.hpp"

namespace ferrule {

std::variant<ControllerFile, PolicyFile> read_law_or_policy(const std::string& file) {
  const Json json = parse_json(read_text(file), file);
  if (JsonFields(json, file).choice("method", {"ceres", "torch"}) == 0)
    return parse_controller(json, file);
  return parse_policy(json, file);
}

MakeController load_controller(const std::string& file) {
  const std::variant<ControllerFile, PolicyFile> either = read_law_or_policy(file);
  if (const auto* law = std::get_if<ControllerFile>(&either)) return controller_maker(law->law());
  return controller_maker(PolicyController(std::get<PolicyFile>(either).policy));
}

}  // namespace ferrule
