#include "controller/trained_on.hpp"

#include <fmt/format.h>

#include <cmath>

#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

std::vector<std::string> read_texts(JsonFields& fields, const std::string& key) {
  const Json& value = fields.raw(key);
  if (!value.is_array()) fields.refuse(key, "must be a list of texts");
  std::vector<std::string> texts;
  for (const Json& each : value) {
    if (!each.is_string()) fields.refuse(key, "must be a list of texts");
    texts.push_back(each);
  }
  return texts;
}

Json to_json(const std::vector<TrainedEpisode>& episodes) {
  Json list = Json::array();
  for (const TrainedEpisode& e : episodes) {
    list.push_back({{"file", e.file}, {"sha1", e.sha1}});
    if (e.seed) list.back().update({{"seed", *e.seed}, {"trial", e.trial.value_or(0)}});
  }
  return list;
}

std::vector<TrainedEpisode> read_episodes(JsonFields& fields, const std::string& key) {
  const Json& list = fields.raw(key);
  if (!list.is_array()) fields.refuse(key, "must be a list of objects");
  std::vector<TrainedEpisode> episodes;
  for (std::size_t i = 0; i < list.size(); ++i) {
    JsonFields entry = fields.object(key, i);
    TrainedEpisode& episode = episodes.emplace_back();
    episode.file = entry.text("file");
    episode.sha1 = entry.text("sha1");
    if (entry.present("seed")) {
      episode.seed = static_cast<std::uint64_t>(entry.integer("seed", 0, INT64_MAX));
      episode.trial = static_cast<std::uint64_t>(entry.integer("trial", 0, INT64_MAX));
    }
    entry.finish();
  }
  return episodes;
}

}  // namespace

void expect_heading(JsonFields& fields, const std::string& method, std::int64_t version) {
  fields.choice("format", {kControllerFormat});
  fields.integer("format_version", version, version);
  fields.choice("method", {method});
  fields.choice("world", {"hand"});
}

Rule range_of(const Gain& gain) {
  return gain.range == Gain::positive       ? rule::positive()
         : gain.range == Gain::not_negative ? rule::not_negative()
                                            : rule::any();
}

bool differ(const Scaling& a, const Scaling& b) noexcept {
  constexpr double kSame = 1e-9;  // relative
  return std::abs(a.motion - b.motion) > kSame * std::abs(b.motion) ||
         std::abs(a.force - b.force) > kSame * std::abs(b.force);
}

std::string scaling_trouble(const std::optional<Scaling>& trained, const std::string& who,
                            const Scene& scene) {
  if (!trained) return {};
  const Scaling here = scene_scaling(scene);
  if (!differ(here, *trained)) return {};
  return fmt::format(
      "{}: {} scales the hand otherwise (alpha_x {:.6g}, alpha_f {:.6g}) than what it learned from "
      "({:.6g}, {:.6g}): what was learned there means nothing here",
      who, scene.name, here.motion, here.force, trained->motion, trained->force);
}

Json to_json(const TrainedOn& t) {
  Json json = {{"scenes", t.scenes},
               {"episodes", to_json(t.episodes)},
               {"held_out", to_json(t.held_out)},
               {"rows", t.rows},
               {"seed", t.seed}};
  if (t.partial) json["partial"] = true;
  if (t.rollouts > 0) json["rollouts"] = t.rollouts;
  if (t.scaling) json["scaling"] = {{"alpha_x", t.scaling->motion}, {"alpha_f", t.scaling->force}};
  if (t.speed_limit > 0)
    json["limits"] = {{"speed_um_s", 1e6 * t.speed_limit}, {"force_uN", 1e6 * t.force_limit}};
  if (!t.scene.is_null()) json["scene"] = t.scene;
  return json;
}

TrainedOn read_trained_on(JsonFields& fields, const std::string& file) {
  JsonFields trained = fields.object("trained_on");
  TrainedOn t;
  t.scenes = read_texts(trained, "scenes");
  t.episodes = read_episodes(trained, "episodes");
  t.held_out = read_episodes(trained, "held_out");
  t.rows = static_cast<std::size_t>(trained.integer("rows", 0, INT64_MAX));
  t.seed = static_cast<std::uint64_t>(trained.integer("seed", 0, INT64_MAX));
  if (trained.present("partial")) {
    if (!trained.raw("partial").is_boolean()) trained.refuse("partial", "must be true or false");
    t.partial = trained.raw("partial");
  }
  if (trained.present("rollouts"))
    t.rollouts = static_cast<std::size_t>(trained.integer("rollouts", 0, INT64_MAX));
  if (trained.present("scaling")) {
    JsonFields scaling = trained.object("scaling");
    t.scaling.emplace();
    t.scaling->motion = scaling.number("alpha_x", rule::positive());
    t.scaling->force = scaling.number("alpha_f", rule::positive());
    scaling.finish();
  }
  if (trained.present("limits")) {
    JsonFields limits = trained.object("limits");
    t.speed_limit = 1e-6 * limits.number("speed_um_s", rule::positive());
    t.force_limit = 1e-6 * limits.number("force_uN", rule::positive());
    limits.finish();
  }
  if (trained.present("scene")) {
    t.scene = trained.raw("scene");
    parse_scene(t.scene, file + ": trained_on.scene");
  }
  trained.finish();
  return t;
}

}  // namespace ferrule
