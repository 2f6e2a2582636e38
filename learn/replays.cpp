#include "learn/replays.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "insertion/scene_scaling.hpp"
#include "sim/solver/follow.hpp"

namespace ferrule {
namespace {

constexpr double kEvery = 0.01;  // between rows compared [s]

Eigen::Index stride(const Recording& r) {
  return std::max<Eigen::Index>(1, std::lround(kEvery / r.period));
}

// Standard deviation of what rounding does [N].
double rounding(const ForceSensorModel& sensor) {
  return sensor.resolution / std::sqrt(12.0);
}

}  // namespace

Recording recording(const Episode& episode, const std::string& file) {
  const Scaling scaling = scene_scaling(recorded_scene(episode.info, file));
  Recording r{file, episode.info.period, episode.rows.middleCols<kPose>(kHandPose.begin),
              episode.rows.middleCols<kPose>(kHolder.begin)};
  for (Eigen::Index n = 0; n < r.hand.rows(); ++n)
    r.hand.row(n) = scaling.motion_to_tip(r.hand.row(n).transpose()).transpose();
  return r;
}

Replays::Replays(const std::vector<Recording>& recordings, const Scene& scene,
                 const std::vector<SceneNumber>& numbers)
    : recordings_(recordings), scene_(scene), numbers_(numbers) {
  const double force = scene.limits.force, moment = force * scene.world.holder.tilt_length;
  unit_ << force, force, force, moment, moment;
  for (const Recording& r : recordings_) {
    first_.push_back(rows_);
    rows_ += (r.hand.rows() - 1) / stride(r) + 1;
  }
}

std::pair<Eigen::Index, Eigen::Index> Replays::rows_of(std::size_t recording) const {
  const Eigen::Index end = recording + 1 < first_.size() ? first_[recording + 1] : rows_;
  return {first_[recording], end - first_[recording]};
}

double Replays::white_sensor_noise() const {
  return Eigen::Vector2d(scene_.sensor.noise, rounding(scene_.sensor)).norm();
}

Eigen::VectorXd Replays::sensor_noise() const {
  ForceSensorModel sensor = scene_.sensor;
  sensor.bias = 0;
  Eigen::VectorXd noise(rows_);
  for (std::size_t r = 0; r < recordings_.size(); ++r) {
    const Recording& one = recordings_[r];
    const auto [first, count] = rows_of(r);
    for (Eigen::Index k = 0; k < count; ++k) {
      const Eigen::Index row = k * stride(one);
      const double force = one.wrench.row(row).head<3>().norm();
      const double deviation = sensor.deviation(force, static_cast<double>(row) * one.period);
      noise[first + k] = Eigen::Vector2d(deviation, rounding(sensor)).norm();
    }
  }
  return noise;
}

bool Replays::residuals(const Eigen::MatrixXd& points, Steps steps, Eigen::MatrixXd& result) const {
  std::vector<World> worlds;
  VariableScene varied(scene_);
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    for (std::size_t i = 0; i < numbers_.size(); ++i)
      varied.set(numbers_[i].key(), numbers_[i].value(points(static_cast<Eigen::Index>(i), p)));
    if (!varied.consistent()) return false;
    worlds.push_back(varied.world());
  }
  result.resize(5 * rows_, points.cols());
  tbb::parallel_for(std::size_t{0}, worlds.size() * recordings_.size(), [&](std::size_t job) {
    const std::size_t p = job / recordings_.size(), r = job % recordings_.size();
    const auto column = static_cast<Eigen::Index>(p);
    replay(worlds[p], recordings_[r], steps, result.col(column).data() + 5 * first_[r]);
  });
  return true;
}

void Replays::replay(const World& world, const Recording& r, Steps steps, double* residual) const {
  const Eigen::Index every = stride(r), by = steps == coarse ? every : 1;
  const auto hand = [&](Eigen::Index n) -> Pose { return r.hand.row(n * by).transpose(); };
  follow(world, at_rest(world, hand(0) + world.holder.sag), (r.hand.rows() - 1) / by + 1,
         static_cast<double>(by) * r.period, hand, [&](Eigen::Index n, const StepResult& now) {
           const Eigen::Index row = n * by;
           if (row % every != 0) return true;
           Eigen::Map<Wrench> error(residual + 5 * (row / every));
           error = (now.holder - r.wrench.row(row).transpose()).cwiseQuotient(unit_);
           return true;
         });
}

}  // namespace ferrule
