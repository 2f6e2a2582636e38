#include "controller/searching_operator.hpp"

#include "controller/controller_file.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr double kPeriod = 1e-3;

std::vector<double> search_gains() {
  return std::get<SearchFile>(read_controller("search")).gains;
}

std::function<double()> chance() {
  return [random = RandomStream(1, 1, Draw::operator_hand)]() mutable { return random.uniform(); };
}

TraineeTraits steady() {
  TraineeTraits traits = trainee_traits(1);
  traits.tremor = traits.hesitation_rate = 0;
  return traits;
}

// A hand in free air, of which an operator is told what it does.
struct FreeHand {
  HandPose pose = HandPose::Zero();
  int n = 0;

  Observation observation() const {
    return observe(HandWrench::Zero(), pose, HandPose::Zero(), -1, n * kPeriod);
  }
  void move(const HandTwist& velocity) {
    pose += kPeriod * velocity;
    ++n;
  }
};

class InsertsInSeconds : public ::testing::TestWithParam<const char*> {};

// The scenes say which gripper: with one that gives way, a hand that answers 0.17 s late can touch.
TEST_P(InsertsInSeconds, ByTouchAtSkill08) {
  const Scene scene = load_scene(GetParam());
  const MakeController make = searching_operator(scene, 0.8, 21);
  int inserted = 0;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    const TrialResult result = run_trial(scene, *make(trial), 21, trial);
    inserted += result.outcome == Outcome::inserted;
    EXPECT_LT(result.summary.peak_force, scene.limits.force);
  }
  EXPECT_GE(inserted, 19);
}
INSTANTIATE_TEST_SUITE_P(SearchingOperator, InsertsInSeconds,
                         ::testing::Values("by_hand/sharp", "by_hand/face"),
                         [](const auto& info) { return std::string(info.param).substr(8); });

TEST(SearchingOperator, DoesWhatTheLawDoesOfWhatHeFeltOneDelayBefore) {
  const TraineeTraits traits = steady();
  const auto delay = static_cast<std::size_t>(std::lround(traits.delay / kPeriod));
  const double stiffness = 1e4;
  SearchingOperator person(traits, search_gains(), stiffness, kPeriod, chance());
  SearchLaw law(search_gains(), ferrule_own_hand{traits.delay, stiffness});
  FreeHand hand;
  std::vector<Observation> before;
  double time = 0;
  for (std::size_t n = 0; n < 3000; ++n) {
    before.push_back(hand.observation());
    if (n == 2500) before.back().wrench[0] = 3;  // a touch
    const HandTwist v = person.command(before.back());
    before.back().time = time;  // the same but for its last bits
    time += kPeriod;
    HandTwist expected = HandTwist::Zero();
    if (n >= delay) expected = law.command(before[n - delay]);
    ASSERT_LE((v - expected).norm(), 1e-9 * (1e-6 + expected.norm())) << n;
    hand.move(v);
  }
  EXPECT_LT(hand.pose[0], -1e-3);
}

TEST(SearchingOperator, WhoHesitatesOnlyTrembles) {
  TraineeTraits traits = steady();
  traits.hesitation_rate = 2 / kPeriod;
  traits.tremor = 2e-6;
  SearchingOperator person(traits, search_gains(), 1e4, kPeriod, chance());
  FreeHand hand;
  for (int n = 0; n < 5000; ++n) hand.move(person.command(hand.observation()));
  const HandPose from = hand.pose;
  double farthest = 0;
  for (int n = 0; n < 2000; ++n) {
    hand.move(person.command(hand.observation()));
    farthest = std::max(farthest, (hand.pose - from).head<3>().cwiseAbs().maxCoeff());
  }
  // Between two extremes of a sum of two sinusoids of 1/sqrt(2) of the amplitude.
  EXPECT_GT(farthest, traits.tremor);
  EXPECT_LT(farthest, 2.9 * traits.tremor);
}

// He knows the gripper: one that gives way a tenth as much lets him come a tenth as fast.
TEST(SearchingOperator, ComesNearAsSlowlyAsHisGripperIsStiff) {
  const auto way = [](double stiffness) {
    SearchingOperator person(steady(), search_gains(), stiffness, kPeriod, chance());
    FreeHand hand;
    for (int n = 0; n < 3000; ++n) hand.move(person.command(hand.observation()));
    return -hand.pose[0];
  };
  EXPECT_CLOSE(way(1e6), way(1e5) / 10, 1e-6);
}

TEST(SearchingOperator, IsRefusedWhereItsNumbersAreOfAnotherScaling) {
  EXPECT_NO_THROW(searching_operator(load_scene("bench"), 0.8, 1));
  EXPECT_THROW(searching_operator(load_scene("paper"), 0.8, 1), BadInput);
  EXPECT_NO_THROW(
      searching_operator(load_scene("bench"), OperatorSkill::parse("0.8,delay=0.1"), 1));
  EXPECT_THROW(searching_operator(load_scene("bench"), OperatorSkill::parse("0.8,yield=0.01"), 1),
               BadInput);
}

}  // namespace
}  // namespace ferrule
