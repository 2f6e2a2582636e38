#include "view/said.hpp"

#include "view/browser_device.hpp"
#include "view/frame.hpp"

namespace ferrule {

Json hello_json(const Scene& scene, const std::string& device, const std::string& folder) {
  return {{"protocol", 1},
          {"scene", scene_json(scene)},
          {"columns", frame_columns()},
          {"phases", kPhases},
          {"devices", {kBrowser}},
          {"device", device},
          {"folder", folder},
          {"mode", "live"}};
}

Json ended_json(const InsertionEnd& end, std::uint64_t trial) {
  const InsertionSummary& summary = end.summary;
  return {{"outcome", name(end.outcome)},    {"why", end.why},
          {"time_s", summary.task_time()},   {"peak_force_uN", 1e6 * summary.peak_force},
          {"depth_um", 1e6 * summary.depth}, {"offset_um", 1e6 * summary.offset},
          {"tilt_rad", summary.tilt},        {"trial", trial}};
}

void add_score(Json& ended, const Measures& measures, const Score& score) {
  Json parts;
  for (std::size_t i = 0; i < kParts; ++i) parts[kPartNames[i]] = number_or_null(score.parts[i]);
  ended["score"] = {{"total", number_or_null(score.total)}, {"parts", parts}};
  ended["hint"] = hint(measures, score);
}

Json listed_json(const std::string& file, const EpisodeInfo& info, const Scene& scene,
                 const Measures& measures, bool same_scene, double score) {
  return {{"file", file},
          {"outcome", name(info.outcome)},
          {"score", number_or_null(score)},
          {"time_s", measures[Part::time]},
          {"peak_force_uN", 1e6 * measures[Part::peak_force]},
          {"operator", info.operator_},
          {"trainee", info.trainee},
          {"date", info.date},
          {"session", info.session},
          {"rating", info.rating},
          {"scene", scene.name},
          {"same_scene", same_scene}};
}

}  // namespace ferrule
