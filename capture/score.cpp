#include "capture/score.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <unsupported/Eigen/FFT>

#include "insertion/scene_scaling.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kPadding = 16;
constexpr double kCutOff = 20;  // [Hz]
constexpr double kThreshold = 0.05;
constexpr double kAverage = 0.2;              // of the axial velocity: two periods of tremor [s]
constexpr double kBegins = 0.2, kEnds = 0.1;  // a movement, over the speed limit

// What `best` is divided by, and what divides it.
double amount(const Measures& m, std::size_t part) {
  return m.parts[part] + (part == static_cast<std::size_t>(Part::corrections) ? 1 : 0);
}

}  // namespace

double spectral_arc_length(const Eigen::VectorXd& speed, double period) {
  const auto size = static_cast<std::size_t>(speed.size());
  if (size == 0 || !(speed.cwiseAbs().maxCoeff() > 0)) return 0;
  const std::size_t padded = kPadding * std::bit_ceil(size);
  std::vector<double> profile(padded, 0.0);
  std::copy(speed.begin(), speed.end(), profile.begin());
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(spectrum, profile);
  const double step = 1 / (static_cast<double>(padded) * period);  // [Hz]
  const auto in_band = static_cast<std::size_t>(std::floor(kCutOff / step)) + 1;
  std::vector<double> height(std::min(in_band, spectrum.size()));
  for (std::size_t i = 0; i < height.size(); ++i)
    height[i] = std::abs(spectrum[i]) / std::abs(spectrum[0]);
  std::size_t last = height.size() - 1;
  while (last > 0 && height[last] < kThreshold) --last;
  double length = 0;
  for (std::size_t i = 0; i < last; ++i)
    length += std::hypot(1 / static_cast<double>(last), height[i + 1] - height[i]);
  return -length;
}

int movements(const Eigen::VectorXd& velocity, double limit, double period) {
  const auto width = std::max<Eigen::Index>(1, std::lround(kAverage / period));
  int count = 0, direction = 0;
  double sum = 0;
  for (Eigen::Index n = 0; n < velocity.size(); ++n) {
    sum += velocity[n] - (n >= width ? velocity[n - width] : 0.0);
    const double v = sum / static_cast<double>(width);
    if (direction != 0 && v * direction < kEnds * limit) direction = 0;
    if (direction == 0 && std::abs(v) > kBegins * limit) {
      direction = v > 0 ? 1 : -1;
      ++count;
    }
  }
  return count;
}

Measures measure(const Episode& episode, const Scene& scene) {
  const Rows& rows = episode.rows;
  const double period = episode.info.period;
  InsertionWatch watch(scene, step_of(rows.row(0)).state);
  double depth = 0, contact = 0, force = 0;
  for (Eigen::Index n = 0; n < rows.rows(); ++n) {
    const StepResult result = step_of(rows.row(n));
    watch.after(result);
    depth = std::max(depth, watch.summary().depth);
    const bool touches = result.state.contact[kEnd].closed || result.state.contact[kSide].closed;
    if (!touches) continue;
    contact += period;
    force += period * holder_force(scene.world, result.forces).norm();
  }
  const double motion = scene_scaling(scene).motion;
  const Eigen::VectorXd speed = rows.middleCols<3>(kCommand.begin).rowwise().norm();
  const int moves = movements(rows.col(kCommand.begin), motion * scene.limits.speed, period);
  const InsertionSummary& summary = watch.summary();
  return {{summary.task_time(), summary.peak_force, contact > 0 ? force / contact : 0,
           summary.friction_work, -spectral_arc_length(speed, period),
           static_cast<double>(std::max(0, moves - 1)), contact},
          episode.info.outcome,
          std::min(1.0, depth / scene.success.depth)};
}

std::vector<Score> score(const std::vector<Measures>& episodes) {
  std::array<double, kParts> best;
  best.fill(std::numeric_limits<double>::quiet_NaN());
  for (const Measures& m : episodes)
    for (std::size_t i = 0; i < kParts; ++i)
      if (m.outcome == Outcome::inserted && !(amount(m, i) >= best[i])) best[i] = amount(m, i);
  std::vector<Score> scores;
  for (const Measures& m : episodes) {
    Score s;
    for (std::size_t i = 0; i < kParts; ++i)
      s.parts[i] = amount(m, i) <= best[i] ? 1 : best[i] / amount(m, i);
    s.total = 100 * std::accumulate(s.parts.begin(), s.parts.end(), 0.0) / kParts;
    if (m.outcome != Outcome::inserted) s.total *= 0.5 * m.completion;
    scores.push_back(s);
  }
  return scores;
}

}  // namespace ferrule
