#include "learn/ablation.hpp"

#include <gtest/gtest.h>

#include "learn/candidates.hpp"
#include "learn/record_again.hpp"
#include "tests/policies.hpp"

namespace ferrule {
namespace {

// Answers with what it was told.
class Echo : public Controller {
 public:
  HandTwist command(const Observation& o) noexcept override {
    HandTwist v;
    v << o.wrench[0], o.displacement[1], o.depth, o.wrench[3], o.height;
    return v;
  }
};

const Observation kSeen{HandWrench::Constant(2), 3, 4, HandPose::Constant(5), 6};

HandTwist told(Ablation what) {
  return without(what, controller_maker(Echo()))(0)->command(kSeen);
}

TEST(Ablation, TakesAwayOneThing) {
  const auto twist = [](double a, double b, double c, double d, double e) {
    return (HandTwist() << a, b, c, d, e).finished();
  };
  EXPECT_EQ(told(Ablation::force), twist(0, 5, 3, 0, 6));
  EXPECT_EQ(told(Ablation::memory), twist(2, 0, 3, 2, 6));
  EXPECT_EQ(told(Ablation::tilt), twist(2, 5, 3, 0, 0));
  EXPECT_EQ(told(Ablation::variation), twist(2, 5, 3, 2, 6));
}

TEST(Ablation, TakesFromEachWhatItHas) {
  PolicyFile sees, remembers;
  sees.policy = testing::random_policy(1, {4}, 1, 1);
  remembers.policy = testing::random_policy(1, {4}, 1, 1, 1, 8, true);
  const auto taken = [](const ControllerFile& controller) {
    std::string all;
    for (const Ablation what : {Ablation::force, Ablation::memory, Ablation::tilt})
      if (has(controller, what)) all += name(what)[0];
    return all;
  };
  EXPECT_EQ(taken(LawFile{}), "f");
  EXPECT_EQ(taken(SearchFile{}), "fmt");
  EXPECT_EQ(taken(sees), "f");
  EXPECT_EQ(taken(remembers), "fmt");
}

TEST(Ablation, OfDemonstrationsIsThatOfWhoRunsOnThem) {
  DemonstrationSet set;
  set.demonstrations.resize(1);
  set.demonstrations[0].observations = {kSeen, kSeen};
  set.demonstrations[0].tilt_rates.setOnes(2, 2);
  for (const Ablation what : {Ablation::force, Ablation::memory, Ablation::tilt}) {
    const Demonstration left = without(what, set, 1).demonstrations[0];
    HandTwist v = Echo().command(left.observed(1));
    v.tail<2>() = v.tail<2>().cwiseProduct(left.tilt_rates.row(1).transpose());
    EXPECT_EQ(v, told(what)) << name(what);
  }
}

TEST(Ablation, WithoutVariationAllDemonstrationsStartAlikeWithTheSameParts) {
  const Scene scene =
      load_scene("bench", {"start.distance_um=20", "success.depth_um=8",
                           "ferrule.bore_diameter_um=126..127", "start.lateral_sd_um=3"});
  const DemonstrationSet set = simulated_demonstrations(scene, 0.8, 1, 3);
  EXPECT_EQ(set.documents.size(), 3u);
  const DemonstrationSet alike = without(Ablation::variation, set, 1);
  ASSERT_EQ(alike.demonstrations.size(), 3u);
  ASSERT_EQ(alike.documents.size(), 1u);
  const Scene its = parse_scene(parse_json(alike.documents[0], "alike"), "alike");
  EXPECT_TRUE(its.drawn.empty());
  EXPECT_EQ(its.start.lateral_sd, 0);
  EXPECT_EQ(its.start.tilt_sd, 0);
  // The operator's hand varies as ever.
  EXPECT_NE(alike.demonstrations[0].velocity.row(50), alike.demonstrations[1].velocity.row(50));
}

TEST(Ablation, ANetworkIsTrainedAgainAndALawIsNot) {
  for (const Learner& learner : learners())
    for (const Learner::Variant& variant : learner.variants) {
      const auto less = without(Ablation::memory, learner, variant);
      EXPECT_EQ(less.has_value(), std::string(learner.method) == "torch") << variant.key;
      EXPECT_EQ(less.value_or(variant).options.contains("--samples"), less.has_value());
    }
}

}  // namespace
}  // namespace ferrule
