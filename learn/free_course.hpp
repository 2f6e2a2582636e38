// How a hand yields sideways, whatever course it takes besides.
//
// A law says which course a hand takes where it feels nothing. Where that is not its demonstrator's
// (he presses from some depth on, say), what the law makes of the difference is in its yields as
// well, however tight their intervals. Here the course is the law's own and c, any function of the
// height h before the entrance, the same in all episodes: piecewise linear between kCourseKnots
// knots.
//
//   v_i = v_i(A = 0) + sum over the law's yields A_k along i of A_k dv_i/dA_k + c_i(h),   i = y, z
//
// by least squares over the rows from when the hand begins, with the intervals of
// learn/intervals.hpp.
#pragma once

#include <vector>

#include "controller/law_file.hpp"
#include "learn/samples.hpp"

namespace ferrule {

inline constexpr std::size_t kCourseKnots = 20;  // between which as many rows lie

struct FreeCourse {
  // One per gain of the law; NaN but for yields along y and z.
  std::vector<FittedGain> yields;
  // Of the variance along x, y, z that the course leaves, the share that the yields explain; NaN
  // along x.
  Eigen::Array3d share = Eigen::Array3d::Constant(NAN);
};

// With the derivatives at `gains`. At least two episodes.
FreeCourse free_course(LawKind kind, const std::vector<double>& gains,
                       const std::vector<Samples>& episodes);

// The yields whose intervals reach less than kDetermined of them to each side; NaN for the others.
inline constexpr double kDetermined = 0.1;
std::vector<double> determined(const FreeCourse& free);

// A hand's tremor comes back to it in the force, which biases a yield of the simulated operators by
// up to 0.7 percent; so does a reaction time that is not a multiple of the rows' spacing.
inline constexpr double kLeastError = 0.005;  // of a yield
// The gains with what `determined` says of their yields, and the intervals of those. A yield that is
// not determined stays, and its interval holds that of the free course too. All reach at least
// kLeastError to each side.
std::vector<FittedGain> with_yields(std::vector<FittedGain> gains, const FreeCourse& free);

}  // namespace ferrule
