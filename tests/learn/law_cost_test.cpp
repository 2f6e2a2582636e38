#include "learn/law_cost.hpp"

#include <ceres/cost_function.h>

#include "tests/compare.hpp"
#include "tests/law_episodes.hpp"

namespace ferrule {
namespace {

using testing::kScales;
using testing::law_episodes;
using testing::usual_law;

Eigen::Vector3d error(LawKind kind, const Sample& sample, const LawUnits& units,
                      const std::vector<double>& scaled) {
  std::vector<double> gains;
  for (std::size_t i = 0; i < scaled.size(); ++i) gains.push_back(scaled[i] * units.gains[i]);
  return (law_velocity(kind, gains.data(), sample) - sample.velocity) / units.speed;
}

// Half the sum of Huber's losses (Huber 1964).
double loss(LawKind kind, const Samples& episode, const LawUnits& units,
            const std::vector<double>& scaled) {
  double sum = 0;
  for (const Sample& sample : episode) {
    const double size = error(kind, sample, units, scaled).norm();
    sum += size <= kVelocityHuber ? size * size / 2 : kVelocityHuber * (size - kVelocityHuber / 2);
  }
  return sum;
}

std::vector<double> moved(std::vector<double> scaled, std::size_t i, double by) {
  scaled[i] += by;
  return scaled;
}

struct OfLaw : ::testing::TestWithParam<LawKind> {
  const LawKind kind = GetParam();
  const Law law = usual_law(kind);
  // Noise beyond the loss's threshold in some rows; a number of rows that no block divides.
  const Samples episode = law_episodes(law, 1, 331, 2e-3, 5).front();
  const LawUnits units{law.gains(), kScales.speed};
  const std::vector<double> scaled = std::vector<double>(law.gains().size(), 1.1);
  const std::unique_ptr<ceres::CostFunction> cost = episode_cost(kind, episode, units);
  const Eigen::Index n = static_cast<Eigen::Index>(scaled.size());
  static constexpr double kStep = 1e-5;

  double cost_of(const Eigen::VectorXd& residual) const { return residual.squaredNorm() / 2; }
};

TEST_P(OfLaw, CostIsTheSumOfTheLossesWithAndWithoutDerivatives) {
  Eigen::VectorXd with(n + 2), without(n + 2);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> jacobian(n + 2, n);
  const double* at = scaled.data();
  double* derivatives = jacobian.data();
  ASSERT_TRUE(cost->Evaluate(&at, with.data(), &derivatives));
  ASSERT_TRUE(cost->Evaluate(&at, without.data(), nullptr));
  EXPECT_CLOSE(cost_of(with), loss(kind, episode, units, scaled), 1e-12);
  EXPECT_CLOSE(cost_of(without), loss(kind, episode, units, scaled), 1e-12);

  const Eigen::VectorXd gradient = jacobian.transpose() * with;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double slope = (loss(kind, episode, units, moved(scaled, k, kStep)) -
                          loss(kind, episode, units, moved(scaled, k, -kStep))) /
                         (2 * kStep);
    EXPECT_NEAR(gradient[i], slope, 1e-6 * gradient.norm()) << gain_table(kind)[k].name;
  }
}

TEST_P(OfLaw, SumsAreThoseOfTheWeightedRows) {
  EpisodeSums sums(n);
  int beyond = 0;
  for (const Sample& sample : episode) {
    const Eigen::Vector3d r = error(kind, sample, units, scaled);
    Eigen::MatrixXd jacobian(3, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto k = static_cast<std::size_t>(i);
      jacobian.col(i) = (error(kind, sample, units, moved(scaled, k, kStep)) -
                         error(kind, sample, units, moved(scaled, k, -kStep))) /
                        (2 * kStep);
    }
    const double weight = std::min(1.0, kVelocityHuber / r.norm());
    beyond += weight < 1;
    sums.information += weight * jacobian.transpose() * jacobian;
    sums.score += weight * jacobian.transpose() * r;
  }
  EXPECT_GT(beyond, 10);
  EXPECT_LT(beyond, 321);
  const EpisodeSums ours = episode_sums(kind, episode, units, scaled);
  EXPECT_LT((ours.information - sums.information).norm(), 1e-6 * sums.information.norm());
  EXPECT_LT((ours.score - sums.score).norm(), 1e-6 * sums.score.norm());
}

TEST_P(OfLaw, GainsOfNoLawAreNotEvaluated) {
  for (std::size_t i = 0; i < scaled.size(); ++i) {
    if (gain_table(kind)[i].range != Gain::positive) continue;
    const std::vector<double> none = moved(scaled, i, -scaled[i]);
    const double* at = none.data();
    Eigen::VectorXd residual(n + 2);
    EXPECT_FALSE(cost->Evaluate(&at, residual.data(), nullptr)) << gain_table(kind)[i].name;
  }
}

INSTANTIATE_TEST_SUITE_P(LawCost, OfLaw, ::testing::ValuesIn(kLaws),
                         [](const auto& info) { return std::string(name(info.param)); });

}  // namespace
}  // namespace ferrule
