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
  p.velocity_mean = Eigen::Vector3d(-0.3, 0.4, 0);
  p.velocity_scale.setZero();
  PolicyController controller(p);
  const HandTwist v = controller.command({HandWrench::Zero(), 0, 0});
  EXPECT_CLOSE(v[0], -0.6 * p.speed_limit, 1e-12);
  EXPECT_CLOSE(v[1], 0.8 * p.speed_limit, 1e-12);
}

// The equations of controller/gru.hpp in double precision, and s(a) = 1/(1 + e^-a).
Eigen::VectorXd reference(const Gru& gru, const Eigen::VectorXd& x, const Eigen::VectorXd& h) {
  const Eigen::Index m = gru.units();
  const Eigen::VectorXd a = gru.input_weight.cast<double>() * x + gru.input_bias.cast<double>();
  const Eigen::VectorXd c = gru.memory_weight.cast<double>() * h + gru.memory_bias.cast<double>();
  Eigen::VectorXd next(m);
  for (Eigen::Index i = 0; i < m; ++i) {
    const double r = 1 / (1 + std::exp(-a[i] - c[i])), u = 1 / (1 + std::exp(-a[m + i] - c[m + i]));
    next[i] = (1 - u) * std::tanh(a[2 * m + i] + r * c[2 * m + i]) + u * h[i];
  }
  return next;
}

TEST(Policy, RemembersByItsGatedUnitsTo1e5OfItsScaleAndAnswersTilts) {
  Policy p = random_policy(2, {16}, 1, 5, 3, 24, true);
  p.speed_limit = 1;
  PolicyController controller(p);
  RandomStream random(3, 0, Draw::plan);
  std::vector<Eigen::VectorXd> h(2, Eigen::VectorXd::Zero(24));
  HandTwist expected = HandTwist::Zero();
  for (int n = 0; n < 400; ++n) {
    const Observation o = random_observation(random);
    if (n % 5 == 0) {
      Eigen::VectorXd z = testing::policy_inputs(p, {o}), mean = Eigen::VectorXd::Zero(5);
      for (int i = 0; i < p.inputs(); ++i)
        z[i] = (z[i] - p.mean[p.channel(i)]) / p.scale[p.channel(i)];
      for (std::size_t m = 0; m < 2; ++m) {
        h[m] = reference(p.memories[m], z, h[m]);
        const Eigen::VectorXd hidden =
            (p.members[m][0].weight.cast<double>() * h[m] + p.members[m][0].bias.cast<double>())
                .array()
                .tanh();
        mean +=
            (p.members[m][1].weight.cast<double>() * hidden + p.members[m][1].bias.cast<double>())
                .head(5) /
            2;
      }
      expected = p.velocity_mean + p.velocity_scale.cwiseProduct(mean);
    }
    // In between it goes on.
    const HandTwist v = controller.command(o);
    for (int i = 0; i < 5; ++i) EXPECT_NEAR(v[i], expected[i], 1e-5 * p.velocity_scale[i]) << n;
  }
}

// A touch of long ago decides what it does now.
TEST(Policy, WithAMemoryDependsOnWhatWasLongAgo) {
  const Policy p = random_policy(1, {8}, 1, 1, 7, 16);
  PolicyController touched(p), not_touched(p);
  Observation o{HandWrench::Ones(), 0, 0};
  touched.command(o);
  o.wrench.setZero();
  not_touched.command(o);
  for (int n = 0; n < 20; ++n) {
    const HandTwist a = touched.command(o), b = not_touched.command(o);
    if (n >= 10) {
      EXPECT_GT((a - b).norm(), 1e-9);
    }
  }
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
  for (const Eigen::Index units : {0, 12}) {
    const PolicyController fresh(random_policy(1, {16}, units > 0 ? 1 : 3, 2, 1, units));
    PolicyController used = fresh, again = fresh;
    RandomStream random(5, 0, Draw::plan);
    std::vector<Observation> seen;
    for (int n = 0; n < 9; ++n) seen.push_back(random_observation(random));
    std::vector<HandTwist> first;
    for (const Observation& o : seen) first.push_back(used.command(o));
    for (std::size_t n = 0; n < seen.size(); ++n) EXPECT_EQ(again.command(seen[n]), first[n]);
  }
}

TEST(Policy, DoesNotAllocate) {
  for (const Eigen::Index units : {0, 64}) {
    PolicyController controller(random_policy(3, {64, 64}, units > 0 ? 1 : 3, 40, 1, units));
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
}

}  // namespace
}  // namespace ferrule
