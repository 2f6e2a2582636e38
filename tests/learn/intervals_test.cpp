#include "learn/intervals.hpp"

#include <boost/math/distributions/students_t.hpp>

#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

// Sums of an episode of rows x with residuals r, unweighted.
EpisodeSums sums(const Eigen::MatrixXd& x, const Eigen::VectorXd& r) {
  EpisodeSums s(x.cols());
  s.information = x.transpose() * x;
  s.score = x.transpose() * r;
  return s;
}

// Of a mean over episodes of the same length it is Student's interval of the episodes' means,
// however many rows they have.
TEST(Intervals, OfAMeanAreStudentsOfTheEpisodesMeans) {
  RandomStream random(1, 1, Draw::operator_hand);
  const int episodes = 7;
  for (const int rows : {1, 10, 1000}) {
    std::vector<Eigen::VectorXd> y;
    Eigen::VectorXd means(episodes);
    for (int e = 0; e < episodes; ++e) {
      y.emplace_back(rows);
      for (double& value : y.back()) value = random.normal() + e % 3;
      means[e] = y.back().mean();
    }
    std::vector<EpisodeSums> all;
    for (const auto& each : y)
      all.push_back(
          sums(Eigen::VectorXd::Ones(rows), Eigen::VectorXd::Constant(rows, means.mean()) - each));
    const double sd = std::sqrt((means.array() - means.mean()).square().sum() / (episodes - 1));
    const double t = quantile(boost::math::students_t(episodes - 1), 0.975);
    EXPECT_CLOSE(precision(all, {false}).half_width[0], t * sd / std::sqrt(episodes), 1e-12);
  }
}

// Columns: a parameter that is told, two that only their sum is told of, one that is told nothing
// of, one that is fixed.
TEST(Intervals, AreOpenWhereTheDataTellNothing) {
  RandomStream random(2, 1, Draw::operator_hand);
  std::vector<EpisodeSums> all;
  for (int e = 0; e < 5; ++e) {
    Eigen::MatrixXd x(50, 5);
    Eigen::VectorXd r(50);
    for (int n = 0; n < 50; ++n) {
      const double shared = random.normal();
      x.row(n) << random.normal(), shared, 1e4 * shared, 0, random.normal();
      r[n] = random.normal();
    }
    all.push_back(sums(x, r));
  }
  const Precision p = precision(all, {false, false, false, false, true});
  EXPECT_GT(p.half_width[0], 0);
  for (const int i : {1, 2, 3, 4}) EXPECT_TRUE(std::isnan(p.half_width[i])) << i;
  EXPECT_EQ(p.correlation(1, 2), 0);
  EXPECT_CLOSE(p.correlation(0, 0), 1, 1e-12);
}

// Two columns that share `part`: the correlation of the estimates is the negative of that of the
// columns.
TEST(Intervals, CorrelationOfTwoIsThatOfTheirColumns) {
  for (const double part : {-0.9, 0.0, 0.5, 0.99}) {
    Eigen::MatrixXd x(2, 2);
    x << 1, part, 0, std::sqrt(1 - part * part);
    std::vector<EpisodeSums> all;
    for (int e = 0; e < 3; ++e) all.push_back(sums(x, Eigen::Vector2d(e - 1.0, 1.0 - e)));
    EXPECT_NEAR(precision(all, {false, false}).correlation(0, 1), -part, 1e-12);
  }
}

}  // namespace
}  // namespace ferrule
