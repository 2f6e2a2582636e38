// ferrule view: the operator's window, in a browser.
#include <fmt/format.h>

#include "app/recorded_view.hpp"
#include "app/trained.hpp"
#include "view/page.hpp"

namespace ferrule {
namespace {

struct ViewArguments {
  SceneArguments scene;
  RecordedViewArguments recorded;
  std::string export_to;
};

// One file that replays from disk.
int export_verb(const ViewArguments& a) {
  expect_place_for(a.export_to);
  const std::optional<std::string> page = page_html();
  if (!page) throw BadInput(std::string("view: ") + kNoPage);
  const RecordedView recorded(a.recorded, a.scene);
  write_text(a.export_to, self_contained(*page, recorded.whole()));
  fmt::print(stderr, "{} replays what was recorded, in a browser, by itself\n", a.export_to);
  return kDone;
}

int view_verb(const ViewArguments& a) {
  if (a.export_to.empty()) throw BadInput("view: give --export FILE.html");
  return export_verb(a);
}

}  // namespace

void add_view(CLI::App& app, Run& run) {
  auto* verb = app.add_subcommand("view", "Watch insertions in a browser, or do them there");
  auto a = std::make_shared<ViewArguments>();
  verb->add_option("path", a->recorded.path,
                   "What to replay: an episode, a folder of them; with --trial a controller")
      ->type_name("FILE.h5|DIR|FILE.json");
  a->scene.add_to(*verb, "that of the controller's training, or demo without a controller");
  auto* trial = verb->add_option("--trial", a->recorded.trial,
                                 "Make this trial of a campaign again, and replay it")
                    ->check(CLI::NonNegativeNumber);
  add_seed(*verb, a->recorded.seed, "Seed of the trial's start");
  verb->add_option("--against", a->recorded.against, "The same trial by another, over it")
      ->check(CLI::IsMember({"constant-velocity", "operator"}))
      ->needs(trial);
  verb->add_option("--skill", a->recorded.skill, "Skill of the operator to set against")
      ->capture_default_str()
      ->check(number_between(0, 1));
  verb->add_flag("--supervise", a->recorded.supervise, "Under the supervisor, as in evaluate")
      ->needs(trial);
  add_other_scaling(*verb, a->recorded.other_scaling);
  verb->add_option("--export", a->export_to, "Write one file that replays from disk")
      ->type_name("FILE.html");
  add_examples(*verb, {"view episodes --export episodes.html",
                       "view --trial 3 controller.json --seed 7 --against constant-velocity "
                       "--export trial.html"});
  verb->callback([a, &run] { run = [a] { return view_verb(*a); }; });
}

}  // namespace ferrule
