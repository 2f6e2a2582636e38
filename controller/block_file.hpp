// A file of blocks that only grows, by whole blocks: what a killed process leaves of it is good.
//
//   "FRB1", size and CRC-32 of the content (32-bit little-endian each), content: CBOR (RFC 8949)
//
// A block that is cut off or damaged is passed over up to the next whole one.
#pragma once

#include <cstdint>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>

#include "sim/base/json_fields.hpp"

namespace ferrule {

class BlockReader {
 public:
  explicit BlockReader(std::string file) : file_(std::move(file)) {}

  // Where the content of a block is in the file [bytes].
  struct Place {
    std::uint64_t at;
    std::size_t size;
  };
  // Shows the blocks that were added since the last call; none where the file is not there. A block
  // that is cut off at the end of the file is shown once it is whole. Throws FileTrouble, also for
  // what is not a file of blocks, and what `show` throws.
  void read(const std::function<void(const Json& block, const Place& place)>& show);
  // One that was shown, again. Throws FileTrouble.
  Json read_again(const Place& place) const;

  const std::string& file() const noexcept { return file_; }
  std::uint64_t end() const noexcept { return end_; }          // of the last whole block [bytes]
  std::size_t damaged() const noexcept { return damaged_; }    // stretches between whole blocks
  std::uint64_t cut_off() const noexcept { return cut_off_; }  // bytes after the last whole block

 private:
  std::ifstream open() const;  // fails where it is not there
  // Those of a part of the file that begins at end_.
  void show_blocks(std::string_view part,
                   const std::function<void(const Json&, const Place&)>& show);

  std::string file_;
  std::uint64_t end_ = 0, cut_off_ = 0, in_vain_ = 0;  // in_vain_: bytes of blocks that were not
  std::size_t damaged_ = 0;
};

class BlockWriter {
 public:
  // Makes the file, or cuts off what a killed process left half-written at its end. It is locked:
  // throws FileTrouble where another process writes to it, and for a link, and what is not a file
  // of blocks.
  explicit BlockWriter(const std::string& file);
  BlockWriter(const BlockWriter&) = delete;
  BlockWriter& operator=(const BlockWriter&) = delete;
  ~BlockWriter();

  // On the disk when it returns; absent where it throws FileTrouble, as on a full disk.
  void append(const Json& block);

  // False where the file system has no locks: two that write to it damage each other's blocks,
  // which a reader passes over.
  bool locked() const noexcept { return locked_; }

 private:
  void cut_off_rest() const;

  std::string file_;
  int fd_;
  bool locked_ = true;
};

}  // namespace ferrule
