// The tries at the window: their list, what trainees do with the last one, and the fit to them.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "controller/controller_file.hpp"
#include "sim/scene/draw.hpp"
#include "view/said.hpp"
#include "view/session.hpp"

namespace ferrule {
namespace {

namespace fs = std::filesystem;

// A controller file of the folder that is not there yet.
std::string free_controller(const std::string& folder) {
  for (int n = 1;; ++n) {
    std::string file = fmt::format("{}/controller_{:04}.json", folder, n);
    std::error_code ignored;
    if (!fs::exists(file, ignored)) return file;
  }
}

}  // namespace

void Session::rate(int stars) {
  if (!kept_) throw BadInput("there is no try to rate");
  const std::string file = kept_->file();
  rate_episode(file, stars);
  {
    const std::lock_guard lock(mutex_);
    for (Listed& listed : episodes_)
      if (listed.file == file) listed.json["rating"] = stars;
  }
  say_episodes();
}

void Session::discard_last() {
  if (!kept_) throw BadInput("there is no try to discard");
  const std::string file = kept_->file();
  std::error_code error;
  if (!fs::remove(file, error)) throw BadInput(file_name(file) + ": could not be removed");
  kept_.reset();
  {
    const std::lock_guard lock(mutex_);
    std::erase_if(episodes_, [&](const Listed& listed) { return listed.file == file; });
    said_.erase("ended");
  }
  say_episodes();
  prepare(next_episode_number(settings_.out));
}

void Session::start_fit(const FitMessage& message) {
  if (fit_) throw BadInput("a fit runs already");
  std::vector<std::string> files;
  {
    const std::lock_guard lock(mutex_);
    std::size_t named = 0;
    for (const Listed& listed : episodes_) {
      const auto is_among = [&](const std::vector<std::string>& names) {
        return std::find(names.begin(), names.end(), file_name(listed.file)) != names.end();
      };
      if (listed.json["same_scene"] != true) continue;
      const bool wanted = is_among(message.episodes), left_out = is_among(message.but);
      named += wanted + left_out;
      if ((message.episodes.empty() || wanted) && !left_out) files.push_back(listed.file);
    }
    if (named != message.episodes.size() + message.but.size())
      throw BadInput("fit: an episode that is not on the list, or of another scene");
  }
  if (files.empty()) throw BadInput("fit: there are no episodes of this scene");
  fit_ = std::make_unique<BackgroundFit>(settings_.program, files, free_controller(settings_.out));
  say("fit", {{"state", "running"}, {"progress", 0}, {"episodes", files.size()}});
}

void Session::watch_fit() {
  if (!fit_) return;
  const double before = fit_->progress();
  const BackgroundFit::State state = fit_->poll();
  if (state == BackgroundFit::State::running) {
    if (fit_->progress() != before)
      say("fit", {{"state", "running"}, {"progress", fit_->progress()}, {"part", fit_->part()}});
    return;
  }
  const std::unique_ptr<BackgroundFit> ended = std::move(fit_);
  try {
    if (state == BackgroundFit::State::failed) throw BadInput(ended->text());
    controller_ = load_controller(ended->controller());
    controller_file_ = ended->controller();
    say("fit", {{"state", "done"}, {"progress", 1}, {"controller", file_name(controller_file_)}});
  } catch (const std::exception& error) {
    say("fit", {{"state", "failed"}, {"progress", ended->progress()}, {"text", error.what()}});
  }
  say_state();
}

void Session::read_one_more() {
  const std::string file = unread_.front();
  unread_.pop_front();
  try {
    const EpisodeRows episode = open_episode(file);
    const Scene scene = recorded_scene(episode.info(), file);
    list(episode.info(), measure(episode, scene), file, scene);
  } catch (const std::exception& error) {  // is not ours to mend
    complain(error.what());
  }
  constexpr std::size_t kAtOnce = 16;  // the list is long where many are still to be read
  if (unread_.size() % kAtOnce == 0) say_episodes();
}

void Session::list(const EpisodeInfo& info, const Measures& m, const std::string& file,
                   const Scene& scene) {
  const bool same = undrawn(scene.document()) == undrawn(settings_.scene.document());
  const double scored = same && yardstick_ ? score(m, *yardstick_).total : NAN;
  Json json = listed_json(file_name(file), info, scene, m, same, scored);
  const std::lock_guard lock(mutex_);
  episodes_.push_back({file, std::move(json)});
  std::sort(episodes_.begin(), episodes_.end(),
            [](const Listed& a, const Listed& b) { return a.file < b.file; });
}

void Session::say_episodes() {
  Json list = Json::array();
  {
    const std::lock_guard lock(mutex_);
    for (const Listed& listed : episodes_) list.push_back(listed.json);
  }
  say("episodes", {{"list", list}, {"reading", unread_.size()}});
}

}  // namespace ferrule
