#include "sim/base/content_hash.hpp"

#include <gtest/gtest.h>

#include "sim/base/json_fields.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

// FIPS 180-2, appendix A.
TEST(Sha1, IsThatOfTheStandard) {
  EXPECT_EQ(sha1("abc"), "a9993e364706816aba3e25717850c26c9cd0d89d");
  EXPECT_EQ(sha1(std::string(1'000'000, 'a')), "34aa973cd4c4daa4f61eeb2bdbad27316534016f");
}

TEST(Sha1, DoesNotDependOnThePieces) {
  const testing::TemporaryFolder folder;
  const std::string text(200'001, 'x');
  Sha1 pieces;
  for (std::size_t at = 0; at < text.size(); at += 777)
    pieces.add(text.data() + at, std::min<std::size_t>(777, text.size() - at));
  EXPECT_EQ(pieces.text(), sha1(text));
  write_text(folder / "file", text);
  EXPECT_EQ(sha1_of_file(folder / "file"), sha1(text));
  EXPECT_THROW(sha1_of_file(folder / "none"), FileTrouble);
  EXPECT_THROW(sha1_of_file(folder.path()), FileTrouble);
}

}  // namespace
}  // namespace ferrule
