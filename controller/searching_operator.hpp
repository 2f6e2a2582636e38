// A simulated operator who finds the bore by touch, as skilled people do: gentle contact, a tilt that
// offers an edge, a judgement by what gives, a move, and again; what jams is freed by tilting.
//
// The steps are those of SearchLaw, taken by a trainee's hand (haptic/trainee.hpp): what it feels and
// where it is it knows later by its delay, and it knows this delay, and how stiff the gripper is; it
// goes at its peak speed relative to the law's, hesitates, for which the law's time stands still,
// and trembles.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "controller/search_law.hpp"
#include "controller/trial.hpp"
#include "insertion/operator_skill.hpp"

namespace ferrule {

class SearchingOperator : public Controller {
 public:
  // `gains` as kSearchGains, the speeds those of the best; `stiffness` of the hand along the bore
  // [N/m]; period between commands [s]; `uniform` is its source of chance, as a Trainee's.
  SearchingOperator(const TraineeTraits& traits, std::vector<double> gains, double stiffness,
                    double period, std::function<double()> uniform);

  HandTwist command(const Observation& observation) noexcept override;
  const char* phase_name() const noexcept override { return law_.phase_name(); }

 private:
  double period_;
  UnsteadyHand hand_;
  SearchLaw law_;
  double law_time_ = 0;                // [s]
  std::vector<Observation> observed_;  // ring: of the last `delay` seconds
  std::size_t next_ = 0, seen_ = 0;
};

// Of `skill` in a scene, with the numbers of the shipped `search`. His chance in a trial is that of
// (seed, trial). Throws BadInput where the scene's scaling is not that of the numbers, and where a
// trait of his own is one by which he does nothing: he has delay, peak_speed, tremor and
// hesitation_rate.
MakeController searching_operator(const Scene& scene, const OperatorSkill& skill,
                                  std::uint64_t seed);
// The same with other traits, a period [s] and a source of chance of his own.
std::unique_ptr<Controller> searching_operator(const Scene& scene, const TraineeTraits& traits,
                                               double period, std::function<double()> uniform);

}  // namespace ferrule
