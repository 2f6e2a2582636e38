// A simulated trainee set to a scene's task.
#pragma once

#include <cstdint>
#include <memory>

#include "insertion/operator_skill.hpp"
#include "insertion/trial_setup.hpp"
#include "sim/base/control_period.hpp"

namespace ferrule {

// To push the fibre of the trial a tenth (2 um at least) deeper than the scene's success depth, from
// where the entrance is taken to be, at the scene's speed limit; and where the scene lets him see
// the bore's axis, to steer the end there before the entrance, to where he sees it.
TraineeTask trainee_task(const TrialSetup& trial, double period = kControlPeriod) noexcept;

// A trainee of `skill` whose hand holds the fibre of the trial, with that task and chance of its
// own.
std::unique_ptr<Device> simulated_operator(const TrialSetup& trial, const OperatorSkill& skill,
                                           double period = kControlPeriod);

}  // namespace ferrule
