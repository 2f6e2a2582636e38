// Records episodes so that nothing that was flushed is lost, whenever the process dies.
//
// The running episode is a journal, FOLDER/episode_NNNN.part: a line of JSON (what is known at the
// start) and then the rows as they come, flushed to the operating system every 100 ms of recording.
// Appending to a plain file cannot damage what is in it; an HDF5 file that is killed while it grows
// can be. When the episode ends, the HDF5 file is made of the journal beside its name, renamed to
// episode_NNNN.h5, and the journal is removed. A journal that is left behind is an episode that was
// killed; `recover` makes a file of it up to the last flush.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "capture/episode_writing.hpp"
#include "insertion/loop.hpp"

namespace ferrule {

// A number of a folder that nobody else has: its journal, locked from the start. The process that
// holds the lock owns the journal; `recover` leaves it alone. Where the file system has no locks,
// the process that made the journal owns it, and `recover` leaves alone those that somebody may
// still write to.
class EpisodeClaim {
 public:
  // The first number from `first` on that no file and no other recorder has, with an empty journal;
  // makes the folder if it is not there. Throws FileTrouble.
  EpisodeClaim(const std::string& folder, int first);
  EpisodeClaim(EpisodeClaim&& other) noexcept;
  EpisodeClaim& operator=(EpisodeClaim&&) = delete;
  // Gives the number back where there is nothing in the journal.
  ~EpisodeClaim();

  // A journal that somebody left. Empty where somebody holds it, or it is gone; without locks
  // nobody holds it. Throws FileTrouble where it cannot be locked.
  static std::optional<EpisodeClaim> of_left(const std::string& journal);

  int number() const noexcept { return number_; }
  bool locked() const;  // false: the file system has no locks
  std::string journal() const { return stem_ + ".part"; }
  std::string file() const { return stem_ + ".h5"; }

  // Throws FileTrouble.
  void append(const void* data, std::size_t size) const;
  // Begins to write an episode to `file()`. Where another has taken that name, the journal moves on
  // to the next free number first. Throws FileTrouble.
  void begin(const EpisodeRows& rows);
  // Waits until the same rows are written, and removes the journal. Throws FileTrouble.
  void finish(const EpisodeRows& rows, const WriteProgress& progress = {});
  // Leaves the journal to others, or removes it.
  void leave() noexcept;
  void remove() noexcept;

 private:
  EpisodeClaim() = default;
  void move_on();

  std::string folder_, stem_;
  int number_ = 0;  // 0: of a journal that has none
  int fd_ = -1;
  std::unique_ptr<EpisodeWriting> writing_;
};

class Recorder {
 public:
  // Starts the claimed episode. Throws FileTrouble.
  Recorder(EpisodeClaim claim, const EpisodeInfo& info);
  // In `folder`, episode `number` or the next that is free.
  Recorder(const std::string& folder, int number, const EpisodeInfo& info)
      : Recorder(EpisodeClaim(folder, number), info) {}
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  // Leaves the journal of an episode whose file was not waited for.
  ~Recorder() = default;

  // Throws FileTrouble when the disk is full; the rows flushed before stay recoverable.
  // `counts` are kept where the episode has a mapping.
  void add(const RowVector& row, const RawCounts& counts = RawCounts::Zero());

  // Brings the rows so far to the journal. Throws as `add`.
  void flush();

  // What only the end of the episode tells (why, loop, rating) may be added until it ends.
  EpisodeInfo& info() noexcept { return info_; }
  std::size_t rows() const noexcept { return rows_; }

  // Ends the episode: a child process begins to write its file. Throws FileTrouble.
  void end(Outcome outcome);
  // Waits until the file is whole, and removes the journal; returns the file's name. Throws
  // FileTrouble.
  std::string written(const WriteProgress& progress = {});
  // Both.
  std::string finish(Outcome outcome, const WriteProgress& progress = {});
  std::string file() const { return claim_.file(); }
  // Removes the journal: the episode never was.
  void discard() noexcept;

 private:
  EpisodeRows journal() const;

  EpisodeClaim claim_;
  EpisodeInfo info_;
  std::size_t start_ = 0;          // of the journal's first line [bytes]
  std::size_t rows_ = 0;           // so far
  std::vector<double> unwritten_;  // as in the journal
};

// Records one insertion with `device`, as fast as it goes, and past success until the hand is
// finished. The period is that of recorder.info(). `go_on` is asked in every
// tick; false ends the insertion as `interrupted`. Recorder::finish is left to the caller. Throws
// what `device`, `recorder` and `go_on` throw.
InsertionEnd record_insertion(const TrialSetup& trial, Device& device, Recorder& recorder,
                              const std::function<bool()>& go_on = {});

// Name of an episode file, and the first number that is free in a folder. Throws BadInput where the
// folder has a number above kMostNumber.
inline constexpr int kMostNumber = 999'999'999;
std::string episode_name(int number);
int next_episode_number(const std::string& folder);

// What became of one journal.
struct Recovered {
  std::string journal, file;  // `file` is empty where nothing was recovered
  std::size_t rows = 0;
  Outcome outcome = Outcome::interrupted;
  std::string remark;
  bool damaged = false;  // it, or rows of it, could not be read; what could not is kept
};

// Turns every journal in `folder` that nobody is writing to into an episode of the rows before the
// first that is damaged; such a journal is kept as NAME.part.damaged. Where the file system has no
// locks, one that has rows is left alone for ten minutes after the last, and an empty one for good.
// The outcome is what the rows show, `inserted` once the success depth was reached, or else
// `interrupted`. Where an episode of its name is there already, the journal is removed if header
// and rows agree with it, and else becomes an episode of the next number. A journal that is empty
// or ends with its header is removed; one of which nothing can be read is left as it is. Also
// removes half-written files of recordings that were killed. `go_on` is called before each journal
// with those that are done, and all; false leaves the others as they are. Throws FileTrouble.
std::vector<Recovered> recover(
    const std::string& folder,
    const std::function<bool(std::size_t done, std::size_t all)>& go_on = {});

}  // namespace ferrule
