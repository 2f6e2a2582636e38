#include "app/recorded_view.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "app/given_controller.hpp"
#include "app/interrupt.hpp"
#include "app/trained.hpp"
#include "controller/controller_file.hpp"
#include "controller/device_controller.hpp"
#include "controller/searching_operator.hpp"
#include "controller/supervisor.hpp"

namespace ferrule {
namespace {

constexpr double kFileRate = 100;  // frames a second in a file

ReplayRun run_of(const std::string& file) {
  const Episode episode = read_episode(file);
  if (episode.rows.rows() == 0) throw BadInput(file + ": an episode without rows");
  return replay_of(episode, recorded_scene(episode.info, file), file_name(file));
}

// As the page calls it.
std::string shown_name(const std::string& name) {
  if (!is_baseline(name)) return controller_file(name);
  return name == kStraight ? "constant velocity"
         : name == kSpiral ? "blind spiral"
                           : "operator who searches";
}

}  // namespace

RecordedView::RecordedView(const RecordedViewArguments& a, const SceneArguments& scene) {
  if (a.trial)
    make_trial(a, scene);
  else
    find_episodes(a);
}

void RecordedView::find_episodes(const RecordedViewArguments& a) {
  std::error_code error;
  title_ = file_name(a.path);
  if (!std::filesystem::is_directory(a.path, error)) {
    files_ = {a.path};
    read_episode(a.path);  // says at once what is wrong with it
  } else {
    files_ = episode_files(a.path);
    if (files_.empty()) throw BadInput(a.path + ": no episodes in it");
  }
  for (const std::string& file : files_) provenance_.read(file);
}

void RecordedView::make_trial(const RecordedViewArguments& a, const SceneArguments& arguments) {
  if (a.path.empty() && a.against.empty())
    throw BadInput("view --trial: give a controller, or --against, or both");
  const bool by_person = a.against == "operator";
  std::vector<GivenController> given;
  for (const std::string& name : {a.path, by_person ? "" : a.against})
    if (!name.empty()) given.push_back(given_controller(name, {}, a.seed));
  BroughtScene brought;
  if (!a.path.empty() && given[0].file)
    brought = brought_by(trained_on(*given[0].file), given[0].read);
  const ChosenScene chosen = arguments.choose(brought);
  const Scene& scene = chosen.scene;
  for (const GivenController& each : given) {
    if (each.file)
      refuse_other_scaling(trained_on(*each.file).scaling, each.read, scene, a.other_scaling);
    if (!each.read.empty()) provenance_.read(each.read);
  }
  provenance_.in(chosen).seed("trials", a.seed);
  const auto add = [&](const std::string& who, MakeController make) {
    if (a.supervise) make = supervised(make, supervisor_limits(scene));
    trials_.push_back(replay_of(scene, make, a.seed, *a.trial, who));
    if (trials_.back().frames.empty())
      throw BadInput(
          fmt::format("trial {} under seed {}: the drawn fibre does not fit into the "
                      "drawn bore, so that there is nothing to see",
                      *a.trial, a.seed));
  };
  title_ = fmt::format("trial {} under seed {}", *a.trial, a.seed);
  for (const GivenController& each : given)
    add(shown_name(each.name), each.name == kSearching && is_baseline(kSearching)
                                   ? searching_operator(scene, a.skill, a.seed)
                                   : each.in(scene));
  if (by_person) add("simulated operator", simulated_operators(scene, a.skill, a.seed));
}

std::optional<std::string> RecordedView::json(const std::string& file) const {
  const auto text = [](const Json& json) {
    return json.dump(-1, ' ', false, Json::error_handler_t::replace);
  };
  if (!trials_.empty()) return text(replay_json(title_, trials_));
  for (const std::string& each : files_) {
    if (!file.empty() && file_name(each) != file) continue;
    std::vector<ReplayRun> runs;
    try {
      runs.push_back(run_of(each));
    } catch (const std::runtime_error&) {  // the page begins with one that can be read
      if (!file.empty() || each == files_.back()) throw;
      continue;
    }
    Json json = replay_json(title_, runs);
    if (file.empty())
      for (const std::string& other : files_)
        if (other != each)
          json["runs"].push_back({{"name", file_name(other)}, {"file", file_name(other)}});
    return text(json);
  }
  return std::nullopt;
}

Json RecordedView::whole() const {
  std::vector<ReplayRun> runs = trials_;
  Progress progress("reading", files_.size());
  for (const std::string& file : files_) {
    end_if_interrupted();
    runs.push_back(run_of(file));
    progress(runs.size());
  }
  for (ReplayRun& run : runs) thin(run, kFileRate);
  return replay_json(title_, runs);
}

}  // namespace ferrule
