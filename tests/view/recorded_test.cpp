#include "view/recorded.hpp"

#include <gtest/gtest.h>

#include "controller/campaign.hpp"
#include "insertion/scene_scaling.hpp"
#include "tests/compare.hpp"
#include "view/page_file.hpp"

namespace ferrule {
namespace {

MakeController straight_in(const Scene& scene) {
  return controller_maker(ConstantVelocity(scene_scaling(scene).motion * scene.limits.speed));
}

ReplayRun failed_run(const Scene& scene) {
  for (std::uint64_t trial = 0;; ++trial) {
    ReplayRun run = replay_of(scene, straight_in(scene), 7, trial, "run");
    if (run.outcome == Outcome::force_limit) return run;
  }
}

float time_of(const Frame& frame) {
  return frame[0];  // the first column, as view/frame.cpp has it
}

TEST(Recorded, ATrialMadeAgainEndsAsInItsCampaign) {
  const Scene scene = load_scene("tolerance");  // pairs are drawn, some do not fit
  const auto results = run_campaign(scene, straight_in(scene), 7, 12, 1, [](std::size_t) {});
  for (std::size_t k = 0; k < results.size(); ++k) {
    const ReplayRun run = replay_of(scene, straight_in(scene), 7, k, "run");
    EXPECT_EQ(run.outcome, results[k].outcome);
    EXPECT_EQ(run.frames.empty(), run.outcome == Outcome::infeasible);
    if (run.frames.empty()) continue;
    EXPECT_EQ(time_of(run.frames.back()), static_cast<float>(results[k].summary.time));
  }
}

TEST(Recorded, AFailureSaysWhyAndWhen) {
  const ReplayRun run = failed_run(load_scene("bench"));
  EXPECT_NE(run.why.find("passed the limit of 60 uN"), std::string::npos) << run.why;
  ASSERT_GE(run.events.size(), 3u);
  EXPECT_STREQ(run.events.front().kind, "contact");
  EXPECT_STREQ(run.events.back().kind, "end");
  EXPECT_EQ(run.events.back().row, run.frames.size() - 1);
  EXPECT_TRUE(std::is_sorted(run.events.begin(), run.events.end(),
                             [](const auto& a, const auto& b) { return a.row < b.row; }));
}

TEST(Recorded, ThinningKeepsTheEventsTheirSurroundingsAndTheEnds) {
  const ReplayRun whole = failed_run(load_scene("bench"));
  ReplayRun few = whole;
  thin(few, 30);
  EXPECT_LT(few.frames.size(), whole.frames.size() / 8);
  EXPECT_EQ(few.frames.front(), whole.frames.front());
  EXPECT_EQ(few.frames.back(), whole.frames.back());
  ASSERT_EQ(few.events.size(), whole.events.size());
  for (std::size_t i = 0; i < few.events.size(); ++i)
    EXPECT_EQ(few.frames[few.events[i].row], whole.frames[whole.events[i].row]);
  // Before the first event every millisecond is there.
  const std::size_t at = few.events.front().row;
  EXPECT_CLOSE(time_of(few.frames[at]) - time_of(few.frames[at - 5]), 5e-3, 0.02);
  for (std::size_t n = 1; n < few.frames.size(); ++n)
    EXPECT_LE(time_of(few.frames[n]) - time_of(few.frames[n - 1]), 1.0 / 30 + 1e-3);
}

TEST(PageFile, WhatIsInsideCannotEndItsElement) {
  const std::string page =
      "<p><script type=\"application/json\" id=\"recorded\"></script><script>1</script>";
  const Json inside = {{"name", "</script><img src=x onerror=alert(1)><!--"}};
  const std::string file = self_contained(page, inside);
  const std::size_t begin = file.find("id=\"recorded\">") + 14, end = file.find("</script>", begin);
  EXPECT_EQ(Json::parse(file.substr(begin, end - begin)), inside);
  EXPECT_EQ(file.find("<img"), file.npos);
  EXPECT_THROW(self_contained("<p>another page", inside), FileTrouble);
}

}  // namespace
}  // namespace ferrule
