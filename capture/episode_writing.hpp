// An episode's file that a child process writes (capture/child.hpp) while this one goes on.
#pragma once

#include "capture/child.hpp"
#include "capture/episode.hpp"
#include "sim/base/written_file.hpp"

namespace ferrule {

class EpisodeWriting {
 public:
  // What the child does: writes an episode to `path`, beside `file`.
  using Work = std::function<void(const std::string& path, Child::Parent& parent)>;

  // Begins to write the rows. Throws FileTrouble.
  EpisodeWriting(const std::string& file, const EpisodeRows& rows);
  EpisodeWriting(const std::string& file, const Work& work);
  EpisodeWriting(const EpisodeWriting&) = delete;
  EpisodeWriting& operator=(const EpisodeWriting&) = delete;
  // Without `finish` nothing was written.
  ~EpisodeWriting() = default;

  // Waits for the child, and gives the whole file its name. Throws FileTrouble; where `replace` is
  // false, also if there is a file of that name.
  void finish(const WriteProgress& progress, bool replace);

 private:
  WrittenFile written_;
  Child child_;
};

}  // namespace ferrule
