// The HDF5 layout of an episode file (capture/README.md), as each version of the format has it.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "capture/episode.hpp"
#include "capture/hdf5.hpp"

namespace ferrule {

inline constexpr const char* kFormat = "ferrule episode";
inline constexpr const char* kDemo = "/data/demo_0";
inline constexpr const char* kCountsPath = "/data/demo_0/raw/counts";
inline constexpr const char* kInputsHash = "inputs_sha1";

// Where a block of the rows stands.
std::string rows_path(const Block& b);

// A block as files of a format have it: the second knew no particle, the first neither flow ahead
// of the end nor air there.
Block block_of(Block block, std::uint64_t version);

// The texts that are there where they are not empty.
template <class Info>
auto optional_texts(Info& info) {
  return std::array{std::pair{"mapping", &info.mapping}, std::pair{"coupling", &info.coupling},
                    std::pair{"loop", &info.loop},       std::pair{"why", &info.why},
                    std::pair{"trainee", &info.trainee}, std::pair{"date", &info.date},
                    std::pair{"session", &info.session}, std::pair{"phases", &info.phases}};
}

// All that a file holds of an episode: what it says, but for the hash of its inputs, and block by
// block the numbers of its tables.
class EpisodeTables {
 public:
  // `rows` must outlive it.
  EpisodeTables(const EpisodeRows& rows, const Scene& scene);

  const hdf5::Content& content() const noexcept { return content_; }
  // The next block of each table, in their order; none after the last.
  std::vector<hdf5::Matrix> next();

  // A block of rows and the one after it, which is the last again at the end.
  struct TableRows {
    Eigen::Index first, count;
    Rows rows;              // count + 1
    CountRows counts;       // count
    hdf5::Matrix wrenches;  // as the sensor read them, count + 1
  };
  using Values = std::function<hdf5::Matrix(const TableRows&)>;

 private:
  TableRows next_rows();

  const EpisodeRows& rows_;
  RecordedSensor sensor_;
  Eigen::Index next_ = 0;
  hdf5::Content content_;
  std::vector<Values> values_;  // of each table
};

// The hash of what cannot be computed again from the rest: all attributes, and what the hand did,
// the numbers of the tables at rows_path(kCommand) and kCountsPath.
std::string inputs_sha1(
    const hdf5::Content& content,
    const std::function<hdf5::Matrix(const std::string& path, Eigen::Index first,
                                     Eigen::Index count)>& numbers);

}  // namespace ferrule
