#include "app/scene_arguments.hpp"

#include <fmt/format.h>

#include "app/interrupt.hpp"
#include "app/progress.hpp"
#include "app/scene_keys.hpp"
#include "sim/analysis/plan.hpp"
#include "sim/scene/setting.hpp"

namespace ferrule {
namespace {

// Whoever reads no more than stderr is told too.
void note_accuracy(const Json& document) {
  const double bound = document.value("planned_error_bound", 0.0);
  const double accuracy = document.value("planned_accuracy", 0.0);
  if (bound > accuracy)
    fmt::print(stderr,
               "note: accuracy = {:g} is not reached: the error bound of the plan is {:.2g} "
               "(see ferrule plan)\n",
               accuracy, bound);
}

}  // namespace

void SceneArguments::add_to(CLI::App& verb, const std::string& unless_given) {
  verb.add_option("--scene", scene,
                  "Scene: a file, or the name of a shipped one; unless given " + unless_given)
      ->type_name("NAME|FILE");
  verb.add_option("--set", settings, "Change one value of the scene; can be repeated")
      ->type_name("KEY=VALUE")
      ->expected(1)
      ->take_all();
}

std::string SceneArguments::given() const {
  std::string text = scene.empty() ? "" : " --scene " + scene;
  for (const std::string& setting : settings) text += " --set '" + setting + "'";
  return text;
}

Scene SceneArguments::load() const {
  for (const std::string& setting : settings) refuse_unknown_key(setting);
  return load_scene(name(), settings);
}

ChosenScene SceneArguments::choose(const BroughtScene& brought) const {
  ChosenScene chosen;
  const bool brings = !brought.document.is_null();
  if (scene.empty() && (brings || !brought.open.empty())) {
    for (const std::string& setting : settings) refuse_unknown_key(setting);
    if (!brings) throw BadInput(brought.open + "; choose a scene with --scene");
    Json document = brought.document;
    for (const std::string& setting : settings) apply_setting(document, setting);
    const std::string source = "the scene that " + brought.how;
    chosen.scene = parse_scene(document, source);
    if (!settings.empty()) refuse_contradictions(chosen.scene, source);
    chosen.scene = planned_with_progress(chosen.scene);
    note_accuracy(chosen.scene.document());
    chosen.other = !same_scene(document, brought.document);
    chosen.relation = (chosen.other ? ", changed from what " : ", as ") + brought.how;
    return chosen;
  }
  chosen.file = scene_file(name());
  const Scene loaded = load();
  chosen.scene = planned_with_progress(loaded);
  note_accuracy(chosen.scene.document());
  if (!brings) {
    if (!brought.open.empty()) chosen.relation = "; " + brought.open;
    return chosen;
  }
  chosen.other = !same_scene(chosen.scene.document(), brought.document) &&
                 !same_scene(loaded.document(), brought.document);
  chosen.relation = chosen.other ? ", NOT the scene " + brought.document.value("name", "") +
                                       " that " + brought.how
                                 : ", as " + brought.how;
  return chosen;
}

Scene planned_with_progress(const Scene& scene) {
  Progress progress("planning", 1);
  return planned(scene, [&](std::size_t runs, std::size_t most) {
    end_if_interrupted();
    progress(runs, "", most);
    return true;
  });
}

}  // namespace ferrule
