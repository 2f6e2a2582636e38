// Where the trials of a command are kept: in a folder that several processes share, of which each
// runs a shard and goes on with it where it was killed, or nowhere. A job is a command and what it
// reads; its campaigns (controller/campaign.hpp; the episodes of a recording are one too) come in
// the same order in every process, and a trial is the same wherever it is run. What is kept of it
// is its business: a JSON object, with the same keys in all trials of a campaign.
//
//   begin(campaigns);
//   while (const auto trial = next()) put(*trial, result of it);   // from any number of threads
//   done();
#pragma once

#include <atomic>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "controller/shard_files.hpp"

namespace ferrule {

class TrialStore {
 public:
  // Of one process, which runs all trials and keeps none.
  TrialStore() = default;
  // Of the job `job` in `folder`. It runs those of `shard`, or without one brings together what all
  // shards have run (a merge). `waits`: which campaigns come next depends on the results of those
  // before, so that a shard waits for the others in done(). Throws FileTrouble.
  TrialStore(std::string folder, std::string job, std::optional<Shard> shard, bool waits);

  struct Campaign {
    std::string what;    // the same in every process, and in no other campaign of the job
    std::size_t trials;  // 0, 1, ...
    // Gets the results of other processes, and of this one before it was killed, each once or, where
    // it is there again, twice. False: it differs from the first one. Called by begin, next and
    // done, by one thread at a time.
    std::function<bool(std::size_t trial, const KeptTrial& kept)> take;
  };
  struct Trial {
    std::size_t campaign;  // of those that have begun, from 0
    std::size_t trial;
  };
  // Does somebody look at results here? Not in a shard that neither waits nor is told so by begin.
  bool tells() const noexcept { return !files_ || !shard_ || waits_; }

  // The next campaigns of the job. `all`: the results of other shards are wanted too, whatever
  // tells() says. This and what follows throw FileTrouble, also for trials of another campaign,
  // which another program ran, for those that differ, and what `take` throws.
  void begin(std::vector<Campaign> campaigns, bool all = false);
  // The next trial that is to be run here, by campaign and then in order; empty: there is none.
  std::optional<Trial> next();
  // Keeps a result, of which it asks where it is to be kept.
  void put(const Trial& trial, const std::function<Json()>& result);
  // No more of a campaign is wanted.
  void end(std::size_t campaign);
  // Nothing more is run of these campaigns. Waits for what others run, if it has to, until `stop`; a
  // merge refuses what is missing.
  void done(const std::function<bool()>& stop = {});

  // The shard is whole, all its trials are kept.
  void finish();

  // False where the file system of a shard has no locks (BlockWriter).
  bool locked() const noexcept { return !writer_ || writer_->locked(); }
  // How many trials were there twice.
  std::size_t twice() const noexcept { return twice_; }

 private:
  // A campaign that has begun: of its trials those that this process needs, and which it has.
  struct Running : Campaign {
    std::size_t number;         // in the job
    std::size_t first, stride;  // its trials here: first, first + stride, ...
    std::vector<bool> kept;     // one each
    std::size_t next = 0;       // of them
    bool ended = false;
  };

  bool is_mine(std::size_t trial) const noexcept;
  void look_around();
  void take(Running& running, std::size_t trial, const KeptTrial& kept);
  std::vector<std::size_t> missing(const Running& running);
  [[noreturn]] void refuse(const Running& running, const std::vector<std::size_t>& missing) const;
  Json block(Json content) const;
  void flush();

  std::string job_{};
  std::optional<Shard> shard_ = Shard{1, 1};
  bool waits_ = false;
  std::size_t begun_ = 0;  // campaigns of the job
  bool all_ = false;       // the results of other shards are wanted
  std::size_t twice_ = 0;

  std::mutex reading_{};               // of the files
  std::optional<ShardFiles> files_{};  // empty: nothing is kept
  std::atomic<bool> look_ = false;     // a block was written since others' were read

  std::mutex mutex_{};  // of what follows
  std::vector<Running> running_{};
  std::size_t front_ = 0;  // of them: the first that may have a trial to be run
  std::unique_ptr<BlockWriter> writer_{};
  struct Unwritten {
    Json trials = Json::array(), columns = Json::object();
  };
  std::map<std::size_t, Unwritten> unwritten_{};  // by campaign, of those that have begun
  std::chrono::steady_clock::time_point written_ = std::chrono::steady_clock::now();
};

}  // namespace ferrule
