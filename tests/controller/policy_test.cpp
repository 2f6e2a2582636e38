#include "controller/policy.hpp"

#include "tests/allocations.hpp"
#include "tests/compare.hpp"
#include "tests/policies.hpp"

namespace ferrule {
namespace {

using testing::random_felt;
using testing::random_policy;

// The members' outputs in double precision, from all that was felt so far: (6, members).
Eigen::MatrixXd reference(const Policy& p, const std::vector<Felt>& felt) {
  Eigen::VectorXd z(p.inputs());
  const auto now = static_cast<std::ptrdiff_t>(felt.size()) - 1;
  for (int k = 0; k < p.samples; ++k) {
    const std::ptrdiff_t at = now - k * p.spacing;
    for (int i = 0; i < kFelt; ++i) {
      const auto c = static_cast<std::size_t>(i);
      const double x = at < 0 ? 0.0 : felt[static_cast<std::size_t>(at)].wrench[i];
      z[k * kFelt + i] = (x - p.mean[c]) / p.scale[c];
    }
  }
  z[p.inputs() - 1] = (felt.back().depth - p.mean[kFelt]) / p.scale[kFelt];
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
        std::vector<Felt> felt;
        for (int n = 0; n < 60; ++n) {
          felt.push_back(random_felt(random));
          const HandTwist v = controller.command(felt.back());
          const Eigen::MatrixXd outputs = reference(p, felt);
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
  std::vector<Felt> felt;
  for (int n = 0; n < 9; ++n) felt.push_back(random_felt(random));
  std::vector<HandTwist> first;
  for (const Felt& f : felt) first.push_back(used.command(f));
  for (std::size_t n = 0; n < felt.size(); ++n) EXPECT_EQ(again.command(felt[n]), first[n]);
}

TEST(Policy, DoesNotAllocate) {
  PolicyController controller(random_policy(3, {64, 64}, 3, 40));
  RandomStream random(1, 0, Draw::plan);
  double sum = 0;
  const std::size_t before = testing::allocations();
  for (int n = 0; n < 500; ++n) {
    sum += controller.command(random_felt(random)).norm();
    sum += controller.answer().disagreement.norm();
  }
  EXPECT_EQ(testing::allocations(), before);
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace ferrule
