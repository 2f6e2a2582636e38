// Physical parameters of a scene from recorded forces, with the simulator in the loop.
//
// Each episode's recorded hand is replayed through `step` in the scene with other parameters, and
// the wrench at the holder compared with the recorded one every 10 ms. Minimised over the
// parameters: the sum over these rows of Huber's loss (threshold 0.005) of
//   (F_sim - F_rec) / F_lim,  (M_sim - M_rec) / (F_lim l)        5 numbers [-]
// with F_lim the scene's force limit and l the holder's tilt length.
//
// Where the fibre snaps or sticks, forces jump, at a time that depends on the parameters: the cost
// is not smooth. Hence
// * Huber's loss: the few rows between two jumps cannot outweigh all others;
// * central differences with a step of 2 % (in the coordinate below), wide enough to average over
//   jumps, in place of derivatives; rows that jump within the step are left out of the intervals;
// * several starts: the scene's values, and the best two of 6 random points per parameter, first
//   replayed in steps of 10 ms (fast, forces some nN off), then the best of them as recorded, with
//   the derivatives of the coarse replay.
//
// Each parameter is moved on the scale of learn/scene_number.hpp, to its bounds. Intervals: 95 %,
// learn/intervals.hpp, on that scale; an end beyond a bound is NaN. A parameter is open, and has no
// value, where the data tell nothing about it: no force changes by more than 1e-6 F_lim between its
// bounds, or the interval reaches beyond both bounds, or another parameter can stand for it
// (correlation of the errors above 0.99: hold one of the two fixed).
//
// Does the model fit? The force differences r that are left are held against the noise sigma that
// the scene states of its sensor (and 0.002 F_lim, to which the fit is good):
//   misfit^2 = sum (r - b)^2/sigma^2 / (3 rows - parameters)
// over the rows that do not jump, without the hundredth of them that differ most (a jump that comes
// a moment earlier or later); b is the mean over an episode where the sensor has a bias, otherwise
// 0. Where the sensor is ideal, sigma is the white noise of the recordings themselves, from
// differences of one row to the next. It is 1 where only noise is left. Where it is more than
// noise makes it once in a thousand times, the scene lacks something, or a number that was held
// fixed is wrong: the intervals, which know nothing of that, are wider by this factor (as the
// Particle Data Group scales errors by sqrt(chi^2/(N - 1))).
//
// That limit is the 99.9 % quantile of sqrt(chi^2/n) with n degrees of freedom: those above, but
// fewer where the sensor's errors last (walk, drift, vibration, gain, cross-talk). Of two rows of an
// episode, of which s_i and s_j are the lasting shares of the variance, the errors then have the
// correlation rho = sqrt(s_i s_j), and the variance of the sum grows from the number of rows to the
// sum of rho^2 over all pairs.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "learn/replays.hpp"

namespace ferrule {

enum class Told { fitted, at_bound, open };
const char* name(Told told) noexcept;  // "fitted", "at_bound", "open"

// In the scene document's units.
struct IdentifiedParameter {
  std::string key;  // dotted
  Told told;
  double start, lowest, highest;  // where it started, and its bounds
  double value;                   // NaN if open
  double low, high;               // 95 % interval; NaN where it is not bounded
};

struct Identification {
  std::vector<IdentifiedParameter> parameters;
  // Of the errors of the estimates: near 1 or -1 where one parameter can replace the other. 0 where
  // one is not fitted.
  Eigen::MatrixXd correlation;
  double residual_start, residual;  // root mean square of the force difference [N]
  double noise;                     // of it, what sigma alone would make [N]
  double misfit, misfit_limit;      // [-]; NaN of too few rows
  std::size_t rows;                 // compared

  bool fits() const { return !(misfit > misfit_limit); }
  bool partial = false;  // stopped before the fit was whole
};

// Steps done, of `all` at most. False ends the identification with the best so far.
using IdentifyProgress = std::function<bool(std::size_t done, std::size_t all)>;

// `keys`: dotted names of numbers of the scene. `seed` draws the random starts. Throws
// BadInput: fewer than 3 recordings, a key that is not a number of the scene, is there twice, or
// cannot be varied; and where `progress` ended it before there was anything.
Identification identify(const std::vector<Recording>& recordings, const Scene& scene,
                        const std::vector<std::string>& keys, std::uint64_t seed,
                        const IdentifyProgress& progress = {});

}  // namespace ferrule
