// The files of a job that several processes share, each a shard of its trials.
//
// FOLDER/shard_0003_of_0010.trials (controller/block_file.hpp) has what shard 3 of 10 has run, in
// blocks of about a second. A block says of which job and campaign it is, and has the results of
// some trials by columns:
//
//   {"version", "job", "shard": [3, 10], "campaign", "what", "of": trials of the campaign,
//    "trial": [2, 12, 22], "columns": {"outcome": [...], "time": [...], ...}}
//
// `what` is the same in every process. The last block of a shard that is whole has "done" instead
// of a campaign.
#pragma once

#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "controller/block_file.hpp"

namespace ferrule {

inline constexpr int kShardVersion = 2;  // of what a block holds

// One of the `count` parts of a job, from 1: every count-th trial.
struct Shard {
  std::size_t index, count;

  auto operator<=>(const Shard&) const = default;
};
std::string to_text(const Shard& shard);  // "3/10"
// Of `count` shards the first ones: "shards 3/10, 4/10 and 7 more".
std::string to_text(const std::vector<Shard>& first, std::size_t count);

// What is kept of one trial: a row of a block's columns.
class KeptTrial {
 public:
  KeptTrial(const Json& columns, std::size_t row) noexcept : columns_(columns), row_(row) {}
  // Throws Json::exception where there is none.
  const Json& operator[](const char* name) const { return columns_.at(name).at(row_); }

 private:
  const Json& columns_;
  std::size_t row_;
};

// How far the shards of a job are.
struct JobProgress {
  std::size_t trials = 0;              // that are kept
  std::size_t campaigns = 0;           // that have begun
  std::size_t begun = 0;               // their trials
  std::set<Shard> done{};              // shards that are whole
  std::set<std::size_t> counts{};      // into how many it was divided; empty: none has begun
  std::size_t others = 0;              // blocks of other jobs, which are passed over
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

class ShardFiles {
 public:
  // `job` tells it from other jobs in the same folder.
  ShardFiles(std::string folder, std::string job);

  const std::string& folder() const noexcept { return folder_; }
  std::string file_of(const Shard& shard) const;
  // What a file has that is new; that of all files but one. Throws FileTrouble, also for blocks of
  // another version, blocks that no shard has written, and shards that disagree about a campaign.
  void read(const std::string& file);
  void read_all(const std::string& but = "");
  JobProgress progress() const;

  // Throws FileTrouble where the files have trials of something else as that campaign.
  void expect(std::size_t campaign, const std::string& what) const;
  // Shows what was read of a campaign and was not shown yet, nearly in the order of the trials.
  // Throws FileTrouble, also where `show` throws Json::exception.
  void show_new(std::size_t campaign,
                const std::function<void(std::size_t trial, const KeptTrial&)>& show);

 private:
  void take(const BlockReader& reader, const Json& block, const BlockReader::Place& place);

  std::string folder_, job_;
  std::map<std::string, BlockReader> readers_{};  // by file
  struct Campaign {
    std::string what, file;  // as `file` has it
    struct Block {
      std::size_t first;  // of its trials
      const BlockReader* reader;
      BlockReader::Place place;
    };
    std::vector<Block> blocks{};  // that are not shown yet
  };
  std::map<std::size_t, Campaign> campaigns_{};
  JobProgress progress_{};
};

}  // namespace ferrule
