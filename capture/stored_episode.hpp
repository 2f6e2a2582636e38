// An episode file that anybody may have made, open in a child process (capture/child.hpp).
#pragma once

#include <map>
#include <string>

#include "capture/episode_layout.hpp"

namespace ferrule {

// What is read is checked before: what the file says of itself, that the rows' times are those of
// their numbers, that every number is finite, and that the rows show an insertion where the outcome
// says so: by the rules of its scene (insertion/watch.hpp), and in files of older formats, whose
// rules may have been others, by the depth alone. Allows the child what so large a file may take.
// `file` must outlive this. Throws FileTrouble, naming what is damaged.
class StoredEpisode {
 public:
  explicit StoredEpisode(const MappedFile& file);

  const hdf5::Reader& in() const noexcept { return in_; }
  const EpisodeInfo& info() const noexcept { return info_; }
  Eigen::Index count() const noexcept { return count_; }
  EpisodeRows::Part read(Eigen::Index first, Eigen::Index count) const;
  // Of the table at a path that rows are made of.
  bool is_of_rows(const std::string& path) const noexcept { return tables_.contains(path); }
  hdf5::Matrix numbers(const std::string& path, Eigen::Index first, Eigen::Index count) const;
  // All of them under what is said of them, while it lives.
  EpisodeRows rows(const EpisodeInfo& info) const {
    return {info, count_, [this](auto first, auto count) { return read(first, count); }};
  }

 private:
  void expect_inserted() const;

  std::string file_;
  hdf5::Reader in_;
  EpisodeInfo info_;
  Eigen::Index count_;
  std::map<std::string, hdf5::StoredTable> tables_;  // of kBlocks and the counts, by their path
};

}  // namespace ferrule
