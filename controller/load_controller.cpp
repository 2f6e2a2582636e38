#include "controller/load_controller.hpp"

#include "controller/controller_file.hpp"
#include "controller/policy_file.hpp"

namespace ferrule {

Method controller_method(const std::string& file) {
  const Json json = parse_json(read_text(file), file);
  return static_cast<Method>(JsonFields(json, file).choice("method", {"ceres", "torch"}));
}

MakeController load_controller(const std::string& file) {
  return controller_method(file) == Method::ceres
             ? controller_maker(read_controller(file).law())
             : controller_maker(PolicyController(read_policy(file).policy));
}

}  // namespace ferrule
