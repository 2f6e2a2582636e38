#include "sim/base/error.hpp"

#include <gtest/gtest.h>

namespace ferrule {
namespace {

TEST(Printable, KeepsTextAndTellsTheBytesOfWhatIsNone) {
  EXPECT_EQ(printable("fibre 125 \xc2\xb5m \xe2\x82\xac \xf0\x9f\x98\x80", 100),
            "fibre 125 \xc2\xb5m \xe2\x82\xac \xf0\x9f\x98\x80");
  EXPECT_EQ(printable("a\n\x1b[0m\x7f", 100), "a\\x0a\\x1b[0m\\x7f");
  EXPECT_EQ(printable("\xc2\x9b"
                      "2J\xc2\xa0",
                      100),
            "\\xc2\\x9b"
            "2J\xc2\xa0");  // CSI; a space
  // A byte that begins nothing, one that goes on from nothing, a character cut short, an overlong
  // one and a surrogate.
  EXPECT_EQ(printable("\xff\xba"
                      "e\xe3t\xc0\xaf\xed\xa0\x80",
                      100),
            "\\xff\\xba"
            "e\\xe3t\\xc0\\xaf\\xed\\xa0\\x80");
  EXPECT_EQ(printable("a\xc2", 100), "a\\xc2");
  EXPECT_EQ(printable("\xef\xbf\xbd\xef\xbf\xbf", 100),
            "\xef\xbf\xbd\\xef\\xbf\\xbf");  // U+FFFD, U+FFFF
}

TEST(Printable, LeavesOutTheMiddleOfWhatIsLong) {
  EXPECT_EQ(printable("0123456789", 6), "0123...89");
}

}  // namespace
}  // namespace ferrule
