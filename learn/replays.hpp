// Recordings replayed in scenes with other parameters: how far the forces are from the recorded
// ones.
#pragma once

#include <string>
#include <vector>

#include "capture/episode.hpp"
#include "learn/scene_number.hpp"

namespace ferrule {

// What a replay needs of an episode.
struct Recording {
  std::string file;
  double period;                                                     // between rows [s]
  Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor> hand;    // at the tip's scale [m, rad]
  Eigen::Matrix<double, Eigen::Dynamic, 5, Eigen::RowMajor> wrench;  // at the holder [N, N m]
};

// Throws BadInput (scene not valid).
Recording recording(const Episode& episode, const std::string& file);

class Replays {
 public:
  // Keeps references to all of them.
  Replays(const std::vector<Recording>& recordings, const Scene& scene,
          const std::vector<SceneNumber>& numbers);

  Eigen::Index rows() const { return rows_; }  // compared, one every 10 ms, all recordings
  double unit() const { return unit_[0]; }     // of the force residuals [N]
  // Of a recording: first row, and how many.
  std::pair<Eigen::Index, Eigen::Index> rows_of(std::size_t recording) const;

  // Standard deviation of what the scene's sensor adds to a force of each row, but for a bias that
  // lasts [N]; 0: it is ideal.
  Eigen::VectorXd sensor_noise() const;
  // Of that, what differs from one reading to the next: noise and rounding [N].
  double white_sensor_noise() const;

  // In the steps of the recording, or (fast, forces some nN off) of 10 ms.
  enum Steps { recorded, coarse };
  // (F_sim - F_rec) / F_lim, (M_sim - M_rec) / (F_lim l): 5 per row [-], one column per point,
  // F_lim the scene's force limit and l its holder's tilt length. A point (column of `points`) is
  // the numbers' coordinates. False if one is not a scene.
  bool residuals(const Eigen::MatrixXd& points, Steps steps, Eigen::MatrixXd& result) const;

 private:
  void replay(const World& world, const Recording& recording, Steps steps, double* residual) const;

  const std::vector<Recording>& recordings_;
  const Scene& scene_;
  const std::vector<SceneNumber>& numbers_;
  Wrench unit_;
  std::vector<Eigen::Index> first_;
  Eigen::Index rows_ = 0;
};

}  // namespace ferrule
