// Makes a controller better than its teacher: CMA-ES (cma_es.hpp) over its gains, each candidate
// judged by trials in the simulator.
#pragma once

#include <functional>
#include <vector>

#include "controller/campaign.hpp"
#include "controller/controller_file.hpp"

namespace ferrule {

// What a trial costs, in units of the controller before: success costs nothing, time and peak force
// of an insertion as much as they are of the medians before, and a failure kFailure.
struct Objective {
  static constexpr double kFailure = 10;
  double time = 0, force = 0;  // medians before [s, N]; 0: it does not matter

  double of(const TrialResult& feasible) const;
  // Mean over the trials that are feasible; NaN without any.
  double of(const std::vector<TrialResult>& results) const;
};

// The gains that `improve` changes, by their place: those that are not 0, as a 0 is a term that the
// law does not have; of a search not the sizes of its parts; of a network not its weights, but mean
// and scale of each answer and the scale of each input.
std::vector<std::size_t> free_gains(const ControllerFile& controller);
double gain(const ControllerFile& controller, std::size_t i);
std::string gain_name(const ControllerFile& controller, std::size_t i);
// The controller with the gains `free` times e^x, one x of each.
ControllerFile with_gains(const ControllerFile& controller, const std::vector<std::size_t>& free,
                          const Eigen::VectorXd& x);

// Where a controller is tried, and what a trial there costs.
struct ImproveTask {
  const Scene* scene;
  Objective objective;
};

struct ImproveSettings {
  std::size_t trials = 10000;    // in all, at most
  std::size_t trials_each = 30;  // of a candidate in each task: the same for all of a generation,
                                 // then others
  std::uint64_t seed = 1;
  int threads = 0;
  TrialStore* kept = nullptr;  // of run_campaigns
};

// What one generation takes, and the choice in the end: with fewer trials nothing is changed.
std::size_t least_trials(const ControllerFile& controller, std::size_t tasks,
                         const ImproveSettings& settings);

struct ImproveRow {
  std::size_t trials;  // until then
  double objective;    // of the best candidate of the generation, mean over the tasks
  double spread;       // largest standard deviation of the logarithms of the gains
};

// One of those among which it chose in the end: the controller as it was, and the centre of each
// distribution.
struct ImproveCentre {
  static constexpr std::size_t kTrials = 200;  // of each, in each task

  bool before, chosen;
  double objective;  // mean over the tasks
  // How much more that is than the chosen one's in the same trials: 95 % interval of the mean of the
  // differences, as if normal. The chosen one is the best of several in these trials: where an
  // interval has 0, they do not tell the two apart.
  Interval above_chosen;
};

struct Improved {
  ControllerFile controller;
  std::vector<ImproveRow> rows;
  std::vector<ImproveCentre> choice;  // the first as it was; empty where it was stopped before
  std::size_t trials = 0, restarts = 0;
};

// In all tasks alike, of which there is one at least. Begins with gains that vary by a third. Where
// the distribution has become narrow it begins anew with twice the candidates (Auger and Hansen
// 2005). Of the centres of all distributions, and the controller as it was, it takes the one that is
// best in trials that chose none of them. `stop`, from any thread, ends it: then with the centre of
// the last distribution.
Improved improve(const ControllerFile& controller, const std::vector<ImproveTask>& tasks,
                 const ImproveSettings& settings,
                 const std::function<void(const ImproveRow&)>& progress = {},
                 const std::function<bool()>& stop = {});

}  // namespace ferrule
