// One controller in scenes that differ in some of their values: what sweep, map and sensitivity
// share.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "app/given_controller.hpp"
#include "app/interrupt.hpp"
#include "app/scene_arguments.hpp"
#include "app/shards.hpp"
#include "app/stopping.hpp"
#include "app/trained.hpp"
#include "controller/campaign.hpp"

namespace ferrule {

struct VariedArguments {
  SceneArguments scene;
  std::string controller;
  std::size_t trials;
  std::uint64_t seed = 7;
  int threads = 0;
  bool other_scaling = false;
  Output output;
  const SharedJob* job = nullptr;

  // The controller comes first; `trials_help` says what of, `shards_wait` as add_shard has it.
  void add_controller(CLI::App& verb);
  void add_options(CLI::App& verb, SharedJob& shared, const std::string& trials_help,
                   bool shards_wait = false);
};

class VariedScene {
 public:
  // Throws BadInput, FileTrouble.
  explicit VariedScene(const VariedArguments& arguments);

  // With these "KEY=VALUE" besides. Throws BadInput.
  ChosenScene with(const std::vector<std::string>& settings) const;
  // The controller there; the straight push is as fast as it may be in that scene.
  MakeController controller(const Scene& scene) const { return given_.in(scene); }
  // Of the results, in that scene.
  Provenance provenance(const ChosenScene& chosen) const;
  std::string controller_name() const { return printable(arguments_.controller); }

 private:
  const VariedArguments& arguments_;
  GivenController given_;
  BroughtScene brought_;
};

// A scene with these values, and what the controller did there.
struct Point {
  Json values = Json::object();  // by key
  std::optional<Scene> scene{};  // empty: its parts cannot be together
  std::string redrawn{};         // as of trial_setup
  std::vector<TrialResult> results{};
  CampaignSummary summary = summarise({});
};

// Runs the trials of all points, as far as `stop` lets them go.
void run(const VariedArguments& arguments, const VariedScene& varied,
         const StoppingArguments& stopping, std::vector<Point*> points,
         const std::function<bool()>& stop = interrupted);

// Of a table of summaries, how often they inserted: add(heading, format, cell of a summary).
template <class Add>
void add_success_columns(const Add& add) {
  using S = const CampaignSummary&;
  add("trials", ">7", [](S s) { return Json(s.trials); });
  add("inserted [%]", ">12.1f", [](S s) { return Json(100 * s.success_rate); });
  add("from", ">6.1f", [](S s) { return Json(100 * s.wilson.low); });
  add("to, 95 %", ">8.1f", [](S s) { return Json(100 * s.wilson.high); });
}

// A row of what matters of a summary's JSON, the same for every verb: medians are numbers.
Json short_row(const Json& summary);
Json to_json(const Point& point);

}  // namespace ferrule
