// What is involuntary in the motion of a simulated operator's hand: physiological tremor (8 to
// 12 Hz, three axes) and hesitations.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>

namespace ferrule {

class UnsteadyHand {
 public:
  // Tremor: amplitude of the hand's displacement per axis [m]; hesitations that begin per second
  // [1/s]; period between calls of `drive` [s]; `uniform`: independent numbers in (0, 1).
  UnsteadyHand(double tremor, double hesitation_rate, double period,
               std::function<double()> uniform);

  // Of the period from t [s] on: how much of the intended motion the hand makes, 1, and towards 0
  // while it hesitates. Once per period.
  double drive(double t);
  Eigen::Vector3d tremor_velocity(double t) const noexcept;  // [m/s]

 private:
  struct Sinusoid {
    double frequency, phase;  // [Hz], [rad]
  };

  double amplitude_, hesitation_rate_, period_;
  std::function<double()> uniform_;
  std::array<std::array<Sinusoid, 2>, 3> tremor_;
  double drive_ = 1, pause_until_ = -1;
};

}  // namespace ferrule
