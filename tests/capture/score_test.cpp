#include "capture/score.hpp"

#include <complex>
#include <numeric>

#include "controller/statistics.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

Eigen::VectorXd profile(double duration, double period, const std::function<double(double)>& at) {
  Eigen::VectorXd v(std::lround(duration / period));
  for (Eigen::Index n = 0; n < v.size(); ++n) v[n] = at(static_cast<double>(n) * period);
  return v;
}

Eigen::VectorXd minimum_jerk(double duration, double period = 1e-3) {
  return profile(duration, period, [&](double t) {
    const double q = t / duration;
    return q * q * (1 - q) * (1 - q);
  });
}

// Their spectra are known: V = exp(-2 pi^2 s^2 f^2), and the Fourier integral of 30 q^2 (1 - q)^2
// by Gauss-Legendre quadrature with 200 nodes. The lengths are those of these curves up to
// V = 0.05, as polygons of 2e6 and 3e4 points (numpy). Zeros after the motion make the program's
// bins as fine.
TEST(Smoothness, OfAGaussianAndOfMinimumJerkIsThatOfTheirSpectra) {
  const auto long_after = [](const Eigen::VectorXd& v) {
    Eigen::VectorXd with_zeros = Eigen::VectorXd::Zero(30000);
    with_zeros.head(v.size()) = v;
    return with_zeros;
  };
  const Eigen::VectorXd gauss =
      profile(2, 1e-3, [](double t) { return std::exp(-0.5 * std::pow((t - 1) / 0.1, 2)); });
  EXPECT_CLOSE(spectral_arc_length(long_after(gauss), 1e-3), -1.41645829, 5e-4);
  EXPECT_CLOSE(spectral_arc_length(long_after(minimum_jerk(1)), 1e-3), -1.40816574, 5e-4);
}

// The definition in the header, number by number.
double arc_length_by_definition(const Eigen::VectorXd& v, double period) {
  std::size_t padded = 16;
  while (padded < 16 * static_cast<std::size_t>(v.size())) padded *= 2;
  const auto height = [&](std::size_t k) {
    std::complex<double> sum = 0;
    for (Eigen::Index n = 0; n < v.size(); ++n)
      sum += v[n] * std::polar(1.0, -2 * M_PI * static_cast<double>(k) * static_cast<double>(n) /
                                        static_cast<double>(padded));
    return std::abs(sum) / v.sum();
  };
  std::vector<double> heights;
  for (std::size_t k = 0; k <= padded / 2; ++k)
    if (static_cast<double>(k) <= 20 * period * static_cast<double>(padded))
      heights.push_back(height(k));
  std::size_t last = heights.size() - 1;
  while (last > 0 && heights[last] < 0.05) --last;
  double length = 0;
  for (std::size_t k = 0; k < last; ++k)
    length += std::hypot(1 / static_cast<double>(last), heights[k + 1] - heights[k]);
  return -length;
}

TEST(Smoothness, IsThatOfItsDefinition) {
  RandomStream random(3, 1, "speed");
  for (const double period : {1e-4, 1e-3, 7e-3, 0.02, 0.3})
    for (const Eigen::Index size : {1, 2, 33, 500}) {
      Eigen::VectorXd v(size);
      for (double& x : v) x = 0.2 + random.uniform();
      EXPECT_CLOSE(spectral_arc_length(v, period), arc_length_by_definition(v, period), 1e-9)
          << period << " " << size;
    }
}

TEST(Smoothness, DependsNeitherOnAmplitudeNorOnDuration) {
  const double one = spectral_arc_length(minimum_jerk(1), 1e-3);
  EXPECT_CLOSE(spectral_arc_length(1e-6 * minimum_jerk(1), 1e-3), one, 1e-12);
  EXPECT_CLOSE(spectral_arc_length(1e6 * minimum_jerk(1), 1e-3), one, 1e-12);
  for (const double duration : {0.7, 2.0, 5.0, 13.0})
    EXPECT_CLOSE(spectral_arc_length(minimum_jerk(duration), 1e-3), one, 5e-3);
  EXPECT_CLOSE(spectral_arc_length(minimum_jerk(1, 2e-4), 2e-4), one, 5e-3);
}

TEST(Smoothness, IsWorseWithTremorAndWithPauses) {
  const double smooth = spectral_arc_length(minimum_jerk(5), 1e-3);
  double before = smooth;
  for (const double tremor : {0.01, 0.02, 0.04}) {  // of 11 Hz, beyond 10 Hz
    Eigen::VectorXd v = minimum_jerk(5);
    for (Eigen::Index n = 0; n < v.size(); ++n)
      v[n] += tremor * std::sin(2 * M_PI * 11e-3 * static_cast<double>(n));
    const double now = spectral_arc_length(v, 1e-3);
    EXPECT_LT(now, before - 0.1);
    before = now;
  }
  Eigen::VectorXd paused(11000);
  paused << minimum_jerk(5), Eigen::VectorXd::Zero(1000), minimum_jerk(5);
  EXPECT_LT(spectral_arc_length(paused, 1e-3), smooth - 0.3);
  EXPECT_EQ(spectral_arc_length(Eigen::VectorXd::Zero(100), 1e-3), 0);
}

TEST(Movements, CountWhatBeginsAndEndsBeyondTheDeadBand) {
  const auto pieces = [](std::vector<std::pair<double, double>> list) {  // velocity, duration
    std::vector<double> v;
    for (const auto& [velocity, duration] : list)
      v.insert(v.end(), static_cast<std::size_t>(std::lround(duration / 1e-3)), velocity);
    return Eigen::VectorXd(
        Eigen::Map<Eigen::VectorXd>(v.data(), static_cast<Eigen::Index>(v.size())));
  };
  EXPECT_EQ(movements(pieces({{0, 1}, {-1, 2}, {0, 1}}), 1, 1e-3), 1);
  EXPECT_EQ(movements(pieces({{-1, 1}, {0, 0.5}, {-1, 1}}), 1, 1e-3), 2);
  EXPECT_EQ(movements(pieces({{-1, 1}, {0.5, 0.5}, {-1, 1}}), 1, 1e-3), 3);
  EXPECT_EQ(movements(pieces({{-1, 1}, {-0.3, 1}, {-1, 1}}), 1, 1e-3), 1);  // only slower
  EXPECT_EQ(movements(pieces({{0.15, 3}, {-0.15, 3}}), 1, 1e-3), 0);        // in the dead band
  // Tremor at rest is no movement, whatever its phase.
  for (const double f : {8.0, 9.0, 10.0, 11.0, 12.0})
    EXPECT_EQ(
        movements(profile(5, 1e-3, [&](double t) { return 0.9 * std::sin(2 * M_PI * f * t); }), 1,
                  1e-3),
        0);
}

// Goes in at 10 um/s for 3 s, from 10 um outside to 20 um inside; in contact from 1 s on, with 2 uN
// at the holder sideways but for one second of 4 uN, and friction of 0.5 uN against the motion.
Episode hand_made(const Scene& scene) {
  Episode episode;
  episode.info = testing::info_of(scene, 1, 1);
  episode.info.outcome = Outcome::inserted;
  episode.rows = Rows::Zero(3001, kRowSize);
  for (Eigen::Index n = 0; n <= 3000; ++n) {
    auto row = episode.rows.row(n);
    const double t = 1e-3 * static_cast<double>(n);
    const bool touches = n >= 1000;
    const double force = !touches ? 0 : n < 2000 ? 4e-6 : 2e-6;
    row[kTime.begin] = row[state_column("time")] = t;
    row[state_column("tip_x")] = 10e-6 - 10e-6 * t;
    row[state_column("end_closed")] = touches;
    row[kCommand.begin] = -10e-6 * scene_scaling(scene).motion;
    row.segment<kPose>(kHolder.begin) = scene.world.holder.weight.transpose();
    row[kHolder.begin + 2] += force;
    row[force_column(Term::friction)] = touches ? 0.5e-6 : 0;
  }
  return episode;
}

TEST(Score, MeasuresOfHandMadeRows) {
  const Scene scene = testing::paper({"success.depth_um=15"});
  const Measures m = measure(hand_made(scene), scene);
  EXPECT_CLOSE(m[Part::time], 2.5, 1e-3);
  EXPECT_CLOSE(m[Part::peak_force], 4e-6, 1e-9);
  EXPECT_CLOSE(m[Part::mean_force], 3e-6, 1e-3);
  EXPECT_CLOSE(m[Part::friction_work], 0.5e-6 * 20e-6, 1e-3);
  EXPECT_CLOSE(m[Part::contact_time], 2.0, 1e-3);
  EXPECT_EQ(m[Part::corrections], 0);
  // A box's spectrum, |sin(pi f T)/(pi f T)|, falls below 0.05 in the sixth side lobe.
  EXPECT_GT(m[Part::smoothness], 2);
  EXPECT_EQ(m.completion, 1);
  EXPECT_EQ(m.progress, 1);
  // Each measure that adds up is the sum of its phases.
  for (const Part part : {Part::time, Part::friction_work, Part::contact_time}) {
    const auto& phases = m.by_phase[static_cast<std::size_t>(part)];
    EXPECT_CLOSE(std::accumulate(phases.begin(), phases.end(), 0.0), m[part], 1e-3);
  }
  const Scene deeper = testing::paper({"success.depth_um=40"});
  EXPECT_CLOSE(measure(hand_made(deeper), deeper).completion, 0.5, 1e-3);
  EXPECT_CLOSE(measure(hand_made(deeper), deeper)[Part::time], 3, 1e-3);
}

TEST(Score, IsAgainstTheYardstick) {
  const Yardstick best{{2, 1, 1, 1, 1.5, 0, 1}};
  Measures as_good{best.parts, Outcome::inserted, 1, 1};
  Measures twice{{4, 2, 2, 2, 3, 1, 2}, Outcome::inserted, 1, 1};
  EXPECT_CLOSE(score(as_good, best).total, 100, 1e-14);
  EXPECT_CLOSE(score(twice, best).total, 50, 1e-14);
  for (const double part : score(twice, best).parts) EXPECT_CLOSE(part, 0.5, 1e-14);
  // No correction at all is not infinitely better than one.
  twice.parts = best.parts;
  twice.parts[static_cast<std::size_t>(Part::corrections)] = 1;
  EXPECT_CLOSE(score(twice, best).total, 100 * 6.5 / 7, 1e-14);
  // Better than the yardstick is no better than as good.
  as_good.parts = {1, 0.5, 0.5, 0.5, 1.4, 0, 0.5};
  EXPECT_CLOSE(score(as_good, best).total, 100, 1e-14);
}

TEST(Score, FailuresHavePartialMarksByHowFarTheyCame) {
  const Yardstick best{{2, 1, 1, 1, 1.5, 0, 1}};
  Measures jam{{1, 0.5, 0.5, 0.5, 1, 0, 0.5}, Outcome::jam, 0.8, 0.9};
  EXPECT_CLOSE(score(jam, best).total, 50 * 0.9 * 6 / 7, 1e-14);  // it has no time of success
  const double far = score(jam, best).total;
  jam.progress = 0.3;
  EXPECT_LT(score(jam, best).total, far);
  // One that never touched has shown nothing about contact, however smooth it was.
  const Measures aside{{0.1, 0, 0, 0, 1, 0, 0}, Outcome::stopped_short, 0, 0.5};
  EXPECT_LE(score(aside, best).total, 50 * 0.5 * 3 / 7 + 1e-12);
  const Measures still{{0, 0, 0, 0, 0, 0, 0}, Outcome::interrupted, 0, 0};
  EXPECT_EQ(score(still, best).total, 0);
  // Inserted without a touch: by what it has shown.
  const Measures lucky{{4, 0, 0, 0, 3, 0, 0}, Outcome::inserted, 1, 1};
  EXPECT_CLOSE(score(lucky, best).total, 100 * (0.5 + 1 + 0.5 + 1) / 4, 1e-14);
  EXPECT_TRUE(std::isnan(score(lucky, best).parts[2]));
}

TEST(Score, TheYardstickIsThatOfTheSceneAndNothingElse) {
  const Scene scene = testing::paper({"start.distance_um=10", "success.depth_um=8"});
  const auto first = yardstick(scene), again = yardstick(scene);
  ASSERT_TRUE(first && again);
  EXPECT_EQ(first->parts, again->parts);
  const auto slower = yardstick(
      testing::paper({"start.distance_um=10", "success.depth_um=8", "limits.speed_um_s=1"}));
  ASSERT_TRUE(slower);
  EXPECT_GT(slower->parts[0], 1.5 * first->parts[0]);
  EXPECT_FALSE(yardstick(testing::paper({"limits.force_uN=0.01"})));
}

TEST(Score, TheHintSaysWhatTheHandDidAndShouldDo) {
  const Yardstick best{{2, 1, 1, 1, 1.5, 0, 1}};
  Measures m{best.parts, Outcome::inserted, 1, 1};
  EXPECT_EQ(hint(m, score(m, best)), "");
  const auto set = [&m](Part part, Phase phase, double all, double there) {
    m.parts[static_cast<std::size_t>(part)] = all;
    m.by_phase[static_cast<std::size_t>(part)][static_cast<std::size_t>(phase)] = there;
  };
  set(Part::time, Phase::one_point, 3, 2);
  EXPECT_EQ(hint(m, score(m, best)),
            "you took 3.0 s, 2.0 s of it against the bore's wall: move faster there");
  set(Part::corrections, Phase::approach, 4, 1);
  set(Part::corrections, Phase::cone, 4, 3);
  EXPECT_EQ(hint(m, score(m, best)),
            "you stopped or turned back 3 times on the cone: line up first, then push on");
  // A failure has lost all marks for its time; what it did wrong is worth more to know.
  m = {{4.6, 10e-6, 1, 1, 1.5, 0, 1}, Outcome::force_limit, 0, 0.5};
  set(Part::peak_force, Phase::cone, 10e-6, 10e-6);
  const Yardstick gentle{{5, 3e-6, 1, 1, 1.5, 0, 1}};
  m.clearance = 0.5e-6;
  EXPECT_EQ(hint(m, score(m, gentle)), "you pushed on the cone with 10 uN: push more gently");
  m.off_axis[static_cast<std::size_t>(Phase::cone)] = 2e-6;
  EXPECT_EQ(hint(m, score(m, gentle)),
            "you pushed on the cone with 10 uN while off the axis by 2 um: correct sideways first");
  // The cause came before: where it touched.
  m.touched_off_axis = 7.3e-6;
  EXPECT_EQ(hint(m, score(m, gentle)),
            "you pushed on the cone with 10 uN after you touched 7.3 um off the axis: correct "
            "sideways first");
  m.off_axis = {};
  EXPECT_NE(hint(m, score(m, gentle)).find("touched 7.3 um off"), std::string::npos);
  m.touched_off_axis = 0.4e-6;  // within the clearance
  EXPECT_EQ(hint(m, score(m, gentle)), "you pushed on the cone with 10 uN: push more gently");
  set(Part::peak_force, Phase::seated, 20e-6, 20e-6);
  EXPECT_EQ(hint(m, score(m, gentle)), "you pressed on after the goal: stop there");
}

// Of a try that ends at the goal, and of the same one that goes on.
TEST(Score, WhatComesAfterTheGoalCountsAgainstItAndIsNoUnsteadiness) {
  const Scene scene = testing::paper({"success.depth_um=5"});
  const Episode on = hand_made(scene);
  Episode ended = on;
  Eigen::Index rows = 0;
  while (on.rows(rows, state_column("tip_x")) > -scene.success.depth) ++rows;
  ended.rows = on.rows.topRows(rows + 1).eval();
  const Measures short_one = measure(ended, scene), long_one = measure(on, scene);
  EXPECT_LT(rows + 1, on.rows.rows());
  for (const Part part : {Part::time, Part::smoothness}) EXPECT_EQ(short_one[part], long_one[part]);
  EXPECT_GT(long_one[Part::contact_time], short_one[Part::contact_time]);
  // The last row of one that ends there is on the way to the goal.
  const auto seated = static_cast<std::size_t>(Phase::seated);
  for (const auto& phases : short_one.by_phase) EXPECT_EQ(phases[seated], 0);
  EXPECT_GT(long_one.by_phase[static_cast<std::size_t>(Part::peak_force)][seated], 0);
}

TEST(ScoreAtLength, SkilledTraineesScoreBetter) {
  const testing::TemporaryFolder folder;
  const Scene scene = load_scene("demo", {"start.distance_um=30", "success.depth_um=20"});
  std::vector<Measures> all;
  const std::uint64_t each = 6;
  for (std::uint64_t trial = 1; trial <= 3 * each; ++trial) {
    const double skill = trial <= each ? 0.1 : trial <= 2 * each ? 0.5 : 0.95;
    const Episode episode =
        read_episode(testing::record(scene, folder.path(), trial, nullptr, skill));
    all.push_back(measure(episode, scene));
  }
  const auto fixed = yardstick(scene);
  ASSERT_TRUE(fixed);
  std::array<double, 3> median;
  for (std::size_t i = 0; i < 3; ++i) {
    std::vector<double> totals;
    for (std::size_t k = i * each; k < (i + 1) * each; ++k)
      totals.push_back(score(all[k], *fixed).total);
    median[i] = quantile(totals, 0.5);
  }
  EXPECT_GT(median[1], median[0]);
  EXPECT_GT(median[2], median[1]);
}

// What a row cannot tell apart makes no difference to what InsertionWatch saw while it was
// recorded.
TEST(Score, AgreesWithTheWatchThatSawTheInsertion) {
  const Scene scene = testing::paper({"start.distance_um=10", "success.depth_um=8"});
  const State start = draw_start(scene, 1, 3);
  const auto device = simulated_operator(testing::setup(scene, 3), 0.7);
  const testing::RecordedRows recorded = testing::record_rows(scene, start, *device);
  const InsertionEnd& end = recorded.end;
  const Episode episode{testing::info_of(scene, 1, 3), recorded.matrix(), {}};
  const Measures m = measure(episode, scene);
  EXPECT_CLOSE(m[Part::peak_force], end.summary.peak_force, 1e-12);
  // Of every step, and of every stretch that was extrapolated.
  EXPECT_CLOSE(m[Part::friction_work], end.summary.friction_work, 1e-3);
}

}  // namespace
}  // namespace ferrule
