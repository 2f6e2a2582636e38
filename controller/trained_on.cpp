#include "controller/trained_on.hpp"

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
  for (const TrainedEpisode& e : episodes) list.push_back({{"file", e.file}, {"sha1", e.sha1}});
  return list;
}

std::vector<TrainedEpisode> read_episodes(JsonFields& fields, const std::string& key,
                                          const std::string& file) {
  const Json& list = fields.raw(key);
  if (!list.is_array()) fields.refuse(key, "must be a list of objects");
  std::vector<TrainedEpisode> episodes;
  for (std::size_t i = 0; i < list.size(); ++i) {
    JsonFields entry(list[i], file, "trained_on." + key + "[" + std::to_string(i) + "]");
    episodes.push_back({entry.text("file"), entry.text("sha1")});
    entry.finish();
  }
  return episodes;
}

}  // namespace

Json to_json(const TrainedOn& t) {
  return {{"scenes", t.scenes},
          {"episodes", to_json(t.episodes)},
          {"held_out", to_json(t.held_out)},
          {"rows", t.rows},
          {"seed", t.seed}};
}

TrainedOn read_trained_on(JsonFields& fields, const std::string& file) {
  JsonFields trained = fields.object("trained_on");
  TrainedOn t;
  t.scenes = read_texts(trained, "scenes");
  t.episodes = read_episodes(trained, "episodes", file);
  t.held_out = read_episodes(trained, "held_out", file);
  t.rows = static_cast<std::size_t>(trained.integer("rows", 0, INT64_MAX));
  t.seed = static_cast<std::uint64_t>(trained.integer("seed", 0, INT64_MAX));
  trained.finish();
  return t;
}

}  // namespace ferrule
