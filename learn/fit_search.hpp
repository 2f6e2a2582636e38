// Fits the numbers of an insertion by touch (controller/search_law.hpp) to demonstrations of who
// searches: their phases tell which rows show which number.
//
//   approach_speed   v_x of the first approach
//   near_entrance    height from which on that is nearer the touching speed
//   touch_speed      v_x of the last 50 ms before a touch
//   touch_force      axial force at which a touch begins
//   hold_time        how long a touch lasts, less the reaction time
//   tilt             at a touch that is tilted
//   lift             from the first rest, less what the holder is compressed there
//   insert_speed     v_x of a lift
//   tilt_rate        the fastest on the way from one tilt to another
//   push_force, yield   v_x = -a v_0 (1 - |f|^2/F_p^2) and v_y,z = A f_y,z while it inserts, v_0 the
//                    upper quartile of the speed where less is felt than the shipped touch_force,
//                    a about 1 and the same for all episodes
//
// All forces are those of one reaction time before, which is identified from the insertions
// (learn/samples.hpp) and not imitated, and relative to their median in free air. Minimised with
// Ceres: the sum over rows, every 50 ms, and touches of Cauchy's loss of what is shown relative to
// the number. Its intervals are those of learn/intervals.hpp; they say how far the episodes agree.
// They do not contain what a touch adds in a period: touch_force may come out a fifth too small.
//
// A number that fewer than three episodes show, or whose interval is wider than itself, stays what
// it is in the shipped `search`, and says so; so do the moment with which it turns and the sizes of
// the parts.
#pragma once

#include "learn/learner.hpp"

namespace ferrule {

struct SearchFit {
  SearchFile controller;
  std::vector<FittedGain> gains;  // as kSearchGains; without an interval: not fitted
  double reaction_time = 0;       // [s]
  std::string summary;            // Ceres' own, one line
};

// `seed` draws the split into training and held-out episodes. Throws BadInput where there are fewer
// than 3 successful demonstrations that tell phases, or where their scaling is not that of `search`.
SearchFit fit_search(const DemonstrationSet& set, std::uint64_t seed,
                     const LearnerProgress& progress = {});

// fit_search in the table of learners.
Learner search_learner();

}  // namespace ferrule
