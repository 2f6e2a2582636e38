// Records episodes so that nothing that was flushed is lost, whenever the process dies.
//
// The running episode is a journal, FOLDER/episode_NNNN.part: a line of JSON (what is known at the
// start) and then the rows as they come, flushed to the operating system every 100 ms of recording.
// Appending to a plain file cannot damage what is in it; an HDF5 file that is killed while it grows
// can be. When the episode ends, the whole HDF5 file is written beside its name, renamed to
// episode_NNNN.h5, and the journal is removed. A journal that is left behind is an episode that was
// killed; `recover` makes a file of it up to the last flush.
#pragma once

#include <string>
#include <vector>

#include "capture/episode.hpp"

namespace ferrule {

class Recorder {
 public:
  // Starts episode `number` in `folder`, which must be there. Throws FileTrouble.
  Recorder(const std::string& folder, int number, const EpisodeInfo& info);
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  // Leaves the journal if `finish` was not called.
  ~Recorder();

  // Throws FileTrouble when the disk is full; the rows flushed before stay recoverable.
  // `counts` are kept where the episode has a mapping.
  void add(const RowVector& row, const RawCounts& counts = RawCounts::Zero());

  // Brings the rows so far to the journal. Throws as `add`.
  void flush();

  // What only the end of the episode tells (why, loop, rating) may be added until `finish`.
  EpisodeInfo& info() noexcept { return episode_.info; }
  std::size_t rows() const noexcept { return rows_.size(); }

  // Writes the episode file and removes the journal; returns the file's name. Throws FileTrouble.
  std::string finish(Outcome outcome);
  // Removes the journal: the episode never was.
  void discard() noexcept;

 private:
  std::string journal_, file_;
  Episode episode_;
  std::vector<RowVector> rows_;
  std::vector<RawCounts> counts_;
  std::size_t flushed_ = 0;
  int fd_ = -1;
};

// Name of an episode file, and the first number that is free in a folder.
std::string episode_name(int number);
int next_episode_number(const std::string& folder);

// Reserves the first number from `first` on that no file and no other recorder has, with an empty
// journal; makes the folder if it is not there. Throws FileTrouble.
int claim_episode(const std::string& folder, int first);

// What became of one journal.
struct Recovered {
  std::string journal, file;  // `file` is empty where nothing was recovered
  std::size_t rows = 0;
  std::string remark;
  bool damaged = false;  // it could not be read, and was left as it is
};

// Turns every journal in `folder` that nobody is writing to into an episode with outcome
// `interrupted`. Throws FileTrouble.
std::vector<Recovered> recover(const std::string& folder);

}  // namespace ferrule
