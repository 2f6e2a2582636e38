#include "controller/policy.hpp"

#include "tests/allocations.hpp"
#include "tests/compare.hpp"
#include "tests/policies.hpp"

namespace ferrule {
namespace {

using testing::random_observation;
using testing::random_policy;

// The members' outputs in double precision, from all that was observed so far: (6, members).
Eigen::MatrixXd reference(const Policy& p, const std::vector<Observation>& seen) {
  Eigen::VectorXd z = testing::policy_inputs(p, seen);
  for (int i = 0; i < p.inputs(); ++i) z[i] = (z[i] - p.mean[p.channel(i)]) / p.scale[p.channel(i)];
  Eigen::MatrixXd outputs(2 * kVelocity, p.members.size());
  for (std::size_t m = 0; m < p.members.size(); ++m) {
    Eigen::VectorXd h = z;
    for (const Layer& layer : p.members[m]) {
      h = layer.weight.cast<double>() * h + layer.bias.cast<double>();
      if (&layer != &p.members[m].back()) h = h.unaryExpr([](double x) { return std::tanh(x); });
    }
    outputs.col(static_cast<Eigen::Index>(m)) = h;
  }
  return outputs;
}

TEST(Policy, IsTheNetworkInDoublePrecisionTo1e6OfItsScale) {
  for (const std::size_t members : {1u, 3u})
    for (const int samples : {1, 2, 4})
      for (const int spacing : {1, 7}) {
        Policy p = random_policy(members, {64, 64}, samples, spacing, members + 10u);
        p.speed_limit = 1;  // beyond all answers
        PolicyController controller(p);
        RandomStream random(3, 0, Draw::plan);
        std::vector<Observation> seen;
        for (int n = 0; n < 60; ++n) {
          seen.push_back(random_observation(random));
          const HandTwist v = controller.command(seen.back());
          const Eigen::MatrixXd outputs = reference(p, seen);
          const PolicyAnswer answer = controller.answer();
          for (int i = 0; i < kVelocity; ++i) {
            const double scale = p.velocity_scale[i], mean = outputs.row(i).mean();
            const double sd = std::sqrt((outputs.row(i).array() - mean).square().mean());
            const double predicted =
                std::sqrt((2 * outputs.row(kVelocity + i).array().max(-4).min(2)).exp().mean());
            EXPECT_NEAR(v[i], p.velocity_mean[i] + scale * mean, 1e-6 * scale);
            EXPECT_NEAR(answer.velocity[i], v[i], 1e-12 * scale);
            EXPECT_NEAR(answer.disagreement[i], scale * sd, 1e-6 * scale);
            EXPECT_CLOSE(answer.deviation[i], scale * predicted, 2e-6);
          }
          EXPECT_EQ(v[3], 0);
          EXPECT_EQ(v[4], 0);
        }
      }
}

// The order that controller/README.md states for those who run it elsewhere.
TEST(Policy, TakesInTheWrenchesNewestFirstThenTheDepth) {
  const Policy p = random_policy(1, {8}, 3, 2);
  RandomStream random(4, 0, Draw::plan);
  std::vector<Observation> seen;
  for (int n = 0; n < 9; ++n) seen.push_back(random_observation(random));
  const Eigen::VectorXd inputs = testing::policy_inputs(p, seen);
  EXPECT_EQ(inputs.head<5>(), seen[8].wrench);
  EXPECT_EQ(inputs.segment<5>(kPastChannels), seen[6].wrench);
  EXPECT_EQ(inputs.segment<5>(2 * kPastChannels), seen[4].wrench);
  EXPECT_EQ(inputs[3 * kPastChannels], seen[8].depth);
  EXPECT_EQ(p.channel(3 * kPastChannels - 1), static_cast<std::size_t>(kPastChannels - 1));
}

TEST(Policy, CutsItsSpeed) {
  Policy p = random_policy(1, {8}, 1, 1);
  p.velocity_mean = {-0.3, 0.4, 0};
  p.velocity_scale.setZero();
  PolicyController controller(p);
  const HandTwist v = controller.command({HandWrench::Zero(), 0, 0});
  EXPECT_CLOSE(v[0], -0.6 * p.speed_limit, 1e-12);
  EXPECT_CLOSE(v[1], 0.8 * p.speed_limit, 1e-12);
}

TEST(Policy, OneMemberDoesNotDisagreeWithItself) {
  const Policy one = random_policy(1, {16}, 2, 3);
  Policy twice = one;
  twice.members.push_back(one.members[0]);
  for (const Policy& p : {one, twice}) {
    PolicyController controller(p);
    controller.command({HandWrench::Ones(), 0.1, 0});
    EXPECT_EQ(controller.answer().disagreement.norm(), 0);
  }
}

TEST(Policy, ACopyStartsAfresh) {
  const PolicyController fresh(random_policy(1, {16}, 3, 2));
  PolicyController used = fresh, again = fresh;
  RandomStream random(5, 0, Draw::plan);
  std::vector<Observation> seen;
  for (int n = 0; n < 9; ++n) seen.push_back(random_observation(random));
  std::vector<HandTwist> first;
  for (const Observation& o : seen) first.push_back(used.command(o));
  for (std::size_t n = 0; n < seen.size(); ++n) EXPECT_EQ(again.command(seen[n]), first[n]);
}

TEST(Policy, DoesNotAllocate) {
  PolicyController controller(random_policy(3, {64, 64}, 3, 40));
  RandomStream random(1, 0, Draw::plan);
  double sum = 0;
  const std::size_t before = testing::allocations();
  for (int n = 0; n < 500; ++n) {
    sum += controller.command(random_observation(random)).norm();
    sum += controller.answer().disagreement.norm();
  }
  EXPECT_EQ(testing::allocations(), before);
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace ferrule
