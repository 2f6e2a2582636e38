#include <gtest/gtest.h>

#include "capture/episode.hpp"
#include "sim/base/error.hpp"

namespace ferrule {
namespace {

EpisodeInfo with_phases(const std::string& text) {
  EpisodeInfo info;
  info.phases = text;
  return info;
}

TEST(Phases, ComeBackFromTheirText) {
  std::vector<PhaseBegin> phases;
  EXPECT_EQ(phases_text(phases), "");
  EXPECT_TRUE(phases_of(with_phases(""), 10, "file").empty());
  int row = 0;
  for (const char* name : {"", "approach", "approach", "touch", "", "approach"})
    note_phase(phases, row++, name);
  const std::string text = phases_text(phases);
  EXPECT_EQ(text, R"([[1,"approach"],[3,"touch"],[4,""],[5,"approach"]])");
  const std::vector<PhaseBegin> back = phases_of(with_phases(text), 6, "file");
  ASSERT_EQ(back.size(), phases.size());
  for (std::size_t i = 0; i < back.size(); ++i) {
    EXPECT_EQ(back[i].row, phases[i].row);
    EXPECT_EQ(back[i].name, phases[i].name);
  }
  EXPECT_THROW(phases_of(with_phases(text), 5, "file"), FileTrouble);  // one begins after the end
}

TEST(Phases, ThatAreDamagedAreRefused) {
  for (const char* text : {"[", "5", R"("touch")", "[5]", R"([["touch",0]])", R"([[0]])",
                           R"([[0,1]])", R"([[-1,"touch"]])", R"([[2.5,"touch"]])",
                           R"([[18446744073709551615,"touch"]])", R"([[3,"touch"],[3,"lift"]])",
                           R"([[3,"touch"],[2,"lift"]])", R"([[99999999999999999999,"touch"]])"})
    EXPECT_THROW(phases_of(with_phases(text), 10, "file"), FileTrouble) << text;
}

}  // namespace
}  // namespace ferrule
