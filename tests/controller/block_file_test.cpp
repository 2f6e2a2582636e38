#include "controller/block_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>

#include "tests/refusal.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

struct BlockFile : ::testing::Test {
  testing::TemporaryFolder folder;
  const std::string file = folder / "blocks";

  static Json block(int i) { return {{"number", i}, {"values", {i + 0.1, 1e300, i}}}; }

  void write(int from, int to) const {
    BlockWriter writer(file);
    for (int i = from; i < to; ++i) writer.append(block(i));
  }
  // The numbers of the blocks that are read.
  static std::vector<int> numbers(BlockReader& reader) {
    std::vector<int> all;
    reader.read([&](const Json& b, const BlockReader::Place& place) {
      all.push_back(b.at("number"));
      EXPECT_EQ(b, block(all.back()));
      EXPECT_EQ(b, reader.read_again(place));
    });
    return all;
  }
  std::vector<int> numbers() const {
    BlockReader reader(file);
    return numbers(reader);
  }
  void put(const std::string& bytes) const { std::ofstream(file, std::ios::binary) << bytes; }
};

TEST_F(BlockFile, IsReadAsFarAsItIsWritten) {
  BlockReader reader(file);
  EXPECT_EQ(numbers(reader), std::vector<int>());  // it is not there yet
  write(0, 3);
  EXPECT_EQ(numbers(reader), (std::vector{0, 1, 2}));
  EXPECT_EQ(numbers(reader), std::vector<int>());
  write(3, 5);
  EXPECT_EQ(numbers(reader), (std::vector{3, 4}));
  EXPECT_EQ(reader.end(), std::filesystem::file_size(file));
}

// Killed at any byte: the blocks before are there, and the next writer goes on behind them.
TEST_F(BlockFile, CutOffAnywhereKeepsWhatIsWhole) {
  write(0, 3);
  const std::string whole = read_text(file);
  const std::size_t size = whole.size() / 3;  // all of one size
  for (std::size_t cut = 0; cut <= whole.size(); ++cut) {
    put(whole.substr(0, cut));
    const int left = static_cast<int>(cut / size);
    BlockReader reader(file);
    EXPECT_EQ(numbers(reader).size(), left) << cut;
    EXPECT_EQ(reader.cut_off(), cut % size) << cut;
    write(left, 3);
    EXPECT_EQ(read_text(file), whole) << cut;
  }
}

TEST_F(BlockFile, OneDamagedByteCostsOneBlock) {
  write(0, 3);
  const std::string whole = read_text(file);
  const std::size_t size = whole.size() / 3;
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    put(damaged);
    std::vector<int> left = {0, 1, 2};
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(at / size));
    BlockReader reader(file);
    EXPECT_EQ(numbers(reader), left) << at;
    EXPECT_EQ(reader.damaged(), at / size < 2) << at;  // the last one may still be written
  }
}

// Of several parts of what is read at once, and with blocks larger than that; one is damaged.
TEST_F(BlockFile, IsReadInParts) {
  std::vector<std::size_t> written;
  {
    BlockWriter writer(file);
    for (std::size_t size : {1u, 700'000u, 3'000'000u, 5u, 900'000u, 900'000u, 2u}) {
      writer.append({{"text", std::string(size, 'F')}});
      written.push_back(size);
    }
  }
  const auto sizes = [&] {
    BlockReader reader(file);
    std::vector<std::size_t> all;
    reader.read([&](const Json& b, const BlockReader::Place& place) {
      all.push_back(b.at("text").get<std::string>().size());
      EXPECT_EQ(b, reader.read_again(place));
    });
    EXPECT_EQ(reader.end(), std::filesystem::file_size(file));
    return all;
  };
  EXPECT_EQ(sizes(), written);
  std::string bytes = read_text(file);
  bytes[2'000'000] = 'x';
  put(bytes);
  written.erase(written.begin() + 2);
  EXPECT_EQ(sizes(), written);
}

TEST_F(BlockFile, HasOneWriter) {
  const BlockWriter writer(file);
  EXPECT_EQ(testing::refusal([&] { const BlockWriter other(file); }),
            "trouble: " + file + ": another process is writing to it: give each its own shard");
}

// As on a full disk: what does not fit is absent.
TEST_F(BlockFile, WithoutSpaceTheBlockIsAbsent) {
  write(0, 2);
  const std::size_t size = std::filesystem::file_size(file);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  {
    BlockWriter writer(file);
    const rlimit limit{size + 5, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
    EXPECT_EQ(testing::refusal([&] { writer.append(block(2)); }),
              "trouble: " + file + ": File too large");
    EXPECT_EQ(std::filesystem::file_size(file), size);
    setrlimit(RLIMIT_FSIZE, &before);
    writer.append(block(2));
  }
  std::signal(SIGXFSZ, ignored);
  EXPECT_EQ(numbers(), (std::vector{0, 1, 2}));
}

}  // namespace
}  // namespace ferrule
