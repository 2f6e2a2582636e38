// Which of several episodes are copies of one: who counts episodes as independent counts each once.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "capture/episode.hpp"

namespace ferrule {

struct EpisodeCopy {
  std::string file, original;

  std::string text() const;  // one line
};

class EpisodeCopies {
 public:
  // That `file` is a copy, where an episode before it had the same rows: hand and forces at every
  // moment, to the last bit, whatever else the files say. Reads all rows.
  std::optional<EpisodeCopy> seen(const EpisodeRows& episode, const std::string& file);

 private:
  std::map<std::string, std::string> files_;  // by the hash of their rows
};

}  // namespace ferrule
