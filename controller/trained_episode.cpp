#include "controller/trained_episode.hpp"

namespace ferrule {

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

}  // namespace ferrule
