// The trials of a job that several processes share, each a shard of them, and that any of them goes
// on with where it was killed. A job is a command and what it reads; its campaigns
// (controller/campaign.hpp; the episodes of a recording are one too) come in the same order in
// every process, and a trial is the same wherever it is run. What is kept of it is its business:
// a JSON value.
//
// FOLDER/shard_0003_of_0010.trials (controller/block_file.hpp) has what shard 3 of 10 has run, in
// blocks of about a second. Each says of which job and campaign it is.
#pragma once

#include <atomic>
#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "controller/block_file.hpp"

namespace ferrule {

// One of the `count` parts of a job, from 1: every count-th trial.
struct Shard {
  std::size_t index, count;

  bool has(std::size_t trial) const noexcept { return trial % count == index - 1; }
  auto operator<=>(const Shard&) const = default;
};
std::string to_text(const Shard& shard);  // "3/10"
// Of `count` shards the first ones: "shards 3/10, 4/10 and 7 more".
std::string to_text(const std::vector<Shard>& first, std::size_t count);

class SharedTrials {
 public:
  struct Found {
    std::size_t campaign, trial;
    Json result;
  };

  // To run those of `shard`, or without one to bring together what all shards have run. `job` tells
  // it from other jobs. `waits`: which campaign comes next depends on the results of those before;
  // a shard waits for the others at the end of each. Throws FileTrouble.
  SharedTrials(std::string folder, std::string job, std::optional<Shard> shard, bool waits);

  // For run_campaigns. The number of the next campaign, of `trials` trials; `what` is the same in
  // every process.
  std::size_t begin(const std::string& what, std::size_t trials);
  bool waits() const noexcept { return shard_ && waits_; }
  bool merges() const noexcept { return !shard_; }
  const std::string& folder() const noexcept { return folder_; }
  // False where the file system of a shard has no locks (BlockWriter).
  bool locked() const noexcept { return !writer_ || writer_->locked(); }
  // Is the trial to be run here, unless somebody has it? How many of the first `trials` are, the
  // i-th of them, and which of them one is; not of a merge.
  bool mine(std::size_t trial) const noexcept { return shard_ && shard_->has(trial); }
  std::size_t own_of(std::size_t trials) const noexcept {
    return (trials + shard_->count - shard_->index) / shard_->count;
  }
  std::size_t own_trial(std::size_t i) const noexcept {
    return i * shard_->count + shard_->index - 1;
  }
  std::size_t own_place(std::size_t trial) const noexcept { return trial / shard_->count; }
  // Reads what other shards have written since; that of this one, and of a merge all, was read at
  // the start. Throws FileTrouble, also for trials of another campaign than begun, which another
  // program ran.
  void look_around();
  // Shows what was read of the campaigns that have begun, from number `first` on, each trial once
  // and nearly in their order; how many they are. Throws FileTrouble, also where `show` throws
  // Json::exception of a result that is none, and what else it throws.
  std::size_t found(std::size_t first, const std::function<void(const Found&)>& show);
  // Was a block written since this was asked last?
  bool wrote() noexcept { return wrote_.exchange(false); }
  // Keeps a result; from any thread.
  void keep(std::size_t campaign, std::size_t trial, Json result);
  void flush();
  // A trial is there again. Throws FileTrouble where it is not the same.
  void again(const Found& found, const Json& before);
  // Says which shards lack these trials of a campaign. Throws FileTrouble.
  [[noreturn]] void refuse_missing(std::size_t campaign,
                                   const std::vector<std::size_t>& trials) const;

  // The shard is whole, all its trials are kept.
  void finish();

  // How far the shards are, for people.
  struct Progress {
    std::size_t trials = 0;     // that are kept
    std::size_t campaigns = 0;  // that have begun
    std::size_t begun = 0;      // their trials
    std::set<Shard> done{};     // shards that are whole
    std::set<std::size_t>
        counts{};            // into how many shards the job was divided; empty: none has begun
    std::size_t twice = 0;   // trials that are there again
    std::size_t others = 0;  // blocks of other jobs, which are passed over
    std::vector<std::string> damaged{};  // files with stretches that are passed over

    std::size_t count() const { return counts.empty() ? 0 : *counts.rbegin(); }
    // The shards that are not whole: how many, and the first few. Where it was divided again and
    // again: none if any division is whole.
    struct NotDone {
      std::size_t count = 0;
      std::vector<Shard> first{};
    };
    NotDone not_done() const;
  };
  // Reads what is new.
  Progress progress();

 private:
  void read(const std::string& file);
  void take(const BlockReader& reader, const Json& block, const BlockReader::Place& place);
  void write(std::size_t campaign, Json trials);

  std::string folder_, job_, own_;  // own_: the file of this shard
  std::optional<Shard> shard_;
  bool waits_;
  std::map<std::string, BlockReader> readers_{};  // by file
  struct Begun {
    std::string what;
    std::size_t trials;
  };
  std::vector<Begun> begun_{};  // the campaigns of this process
  struct Campaign {
    std::string what{}, file{};  // as `file` has it
    struct Block {
      std::size_t first;  // of its trials
      const BlockReader* reader;
      BlockReader::Place place;
    };
    std::vector<Block> blocks{};  // that are not shown yet
  };
  std::map<std::size_t, Campaign> campaigns_{};  // as blocks tell of them
  Progress progress_{};

  std::mutex reading_{};  // of what is above
  std::atomic<bool> wrote_ = false;
  std::mutex mutex_{};  // of what follows
  std::unique_ptr<BlockWriter> writer_{};
  std::map<std::size_t, Json> kept_{};  // trials that are not written yet, by campaign
  std::chrono::steady_clock::time_point written_ = std::chrono::steady_clock::now();
};

}  // namespace ferrule
