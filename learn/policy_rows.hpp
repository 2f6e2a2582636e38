// The rows of demonstrations as a network learns from them.
//
// One without a memory gets all of them but for those cut to the speed limit and those in which the
// hand rests (slower than a tenth of the limit: a policy that learned to rest would do so for ever).
// One with a memory gets each demonstration as it went, every `spacing` of the policy; rows cut to
// the limit tell it what was felt there and not how to answer.
//
// The observed wrench of a row is that of one reaction time before, the motion that of the row.
#pragma once

#include <vector>

#include "controller/policy.hpp"
#include "learn/demonstrations.hpp"
#include "learn/torch_policy.hpp"

namespace ferrule {

// Of one demonstration, unscaled.
struct PolicyRows {
  Eigen::MatrixXd input, velocity;  // (inputs, rows), (answers, rows)
  Eigen::RowVectorXd told;          // (rows): 1, or 0 where the velocity says nothing

  Eigen::Index count() const noexcept { return input.cols(); }
};

// `reaction`: time [s].
std::vector<PolicyRows> policy_rows(const std::vector<const Demonstration*>& set, double reaction,
                                    const Policy& policy);
Eigen::Index count(const std::vector<PolicyRows>& all) noexcept;

// Mean and standard deviation of inputs and velocities over the rows; a velocity that does not vary
// gets a scale of 0.
void set_scales(Policy& policy, const std::vector<PolicyRows>& all);
std::vector<TrainingRows> scaled(const Policy& policy, const std::vector<PolicyRows>& all);

// Sum over the rows of the squared error of the translation, without the speed limit [m^2/s^2].
double squared_error(const Policy& policy, const PolicyRows& rows);

}  // namespace ferrule
