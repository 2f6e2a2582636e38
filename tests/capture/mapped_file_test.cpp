#include "capture/mapped_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "sim/base/content_hash.hpp"
#include "sim/base/error.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

TEST(MappedFile, HasTheBytesAndTheHashOfTheFile) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "file";
  for (const std::size_t size : {0UL, 1UL, 5000UL, (1UL << 22) + 3}) {
    std::string bytes(size, 'a');
    for (std::size_t i = 0; i < size; i += 100) bytes[i] = static_cast<char>(i / 100);
    std::ofstream(file) << bytes;
    const MappedFile mapped(file);
    EXPECT_EQ(mapped.sha1(), sha1(bytes));
    mapped.forget();
    EXPECT_TRUE(
        std::equal(bytes.begin(), bytes.end(), mapped.data(), mapped.data() + mapped.size()));
  }
  EXPECT_THROW(MappedFile(folder / "none"), FileTrouble);
  EXPECT_THROW(MappedFile(folder.path()), FileTrouble);
}

}  // namespace
}  // namespace ferrule
