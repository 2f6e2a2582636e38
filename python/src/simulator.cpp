// Stepping: one trial period by period, and many at once.
#include <mutex>

#include "bindings.hpp"
#include "controller/stepped_trial.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/terms.hpp"
#include "worker_pool.hpp"

namespace ferrule::python {
namespace {

constexpr const char* kVelocity = "velocity (x, y, z [m/s], tilt_y, tilt_z [rad/s], of the hand)";

// A trial that several Python threads may hold: one at a time.
class Simulator {
 public:
  Simulator(SharedScene scene, double period) : scene_(std::move(scene)), period_(period) {
    if (!(period > 0 && period <= 1)) throw nb::value_error("period: must be above 0, at most 1 s");
  }

  SceneObservation reset(std::uint64_t seed, std::uint64_t trial, bool feasible) {
    const nb::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    trial_number_ = feasible ? feasible_trial(*scene_, seed, trial).trial : trial;
    trial_ = std::make_unique<SteppedTrial>(scene_, seed, trial_number_, period_);
    return {trial_->observation(), scene_};
  }

  SceneObservation step(nb::handle velocity, std::size_t periods) {
    const HandTwist v = numbers(velocity, 5, kVelocity);
    const nb::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    SteppedTrial& trial = running();
    if (trial.ended())
      throw std::runtime_error("the trial has ended (" + std::string(name(trial.ended()->outcome)) +
                               "): reset the simulator first");
    for (std::size_t n = 0; n < periods && !trial.ended(); ++n) trial.step(v);
    return {trial.observation(), scene_};
  }

  // What is asked for between steps.
  SteppedTrial& running() const {
    if (!trial_) throw std::runtime_error("the simulator is at no trial: reset it first");
    return *trial_;
  }
  template <class Of>
  auto look(const Of& of) const {
    const std::lock_guard lock(mutex_);
    return of(running());
  }
  const SharedScene& scene() const noexcept { return scene_; }
  double period() const noexcept { return period_; }
  std::uint64_t trial_number() const noexcept { return trial_number_; }

 private:
  SharedScene scene_;
  double period_;
  std::uint64_t trial_number_ = 0;
  std::unique_ptr<SteppedTrial> trial_;
  mutable std::mutex mutex_;
};

nb::dict force_dict(const SteppedTrial& trial) {
  const Breakdown breakdown = forces(trial.scene().world, trial.result());
  nb::dict all;
  for (const Term term : kAllTerms) all[info(term).name] = array(breakdown.force(term));
  return all;
}

nb::dict summary_dict(const InsertionSummary& s) {
  nb::dict d;
  d["time_s"] = s.task_time();
  d["peak_force_N"] = s.peak_force;
  d["peak_stress_Pa"] = s.peak_stress;
  d["friction_work_J"] = s.friction_work;
  d["depth_m"] = s.depth;
  d["offset_m"] = s.offset;
  d["tilt_rad"] = s.tilt;
  return d;
}

std::optional<std::string> ended(const SteppedTrial& trial) {
  if (!trial.ended()) return std::nullopt;
  return name(trial.ended()->outcome);
}

// N trials of one scene under one seed, side by side: number i begins with trial i and goes on with
// i + N, i + 2 N ... A row of what each is observed and came to, kWidth numbers.
class Trials {
 public:
  static constexpr int kWidth = 22;
  static constexpr const char* kColumns[] = {"force_x",
                                             "force_y",
                                             "force_z",
                                             "moment_y",
                                             "moment_z",
                                             "depth",
                                             "time",
                                             "force_x_absolute",
                                             "force_y_absolute",
                                             "force_z_absolute",
                                             "moment_y_absolute",
                                             "moment_z_absolute",
                                             "tip_x",
                                             "outcome",
                                             "peak_force",
                                             "trial",
                                             "displacement_x",
                                             "displacement_y",
                                             "displacement_z",
                                             "displacement_tilt_y",
                                             "displacement_tilt_z",
                                             "height"};

  Trials(SharedScene scene, std::size_t count, std::size_t periods, int threads)
      : scene_(std::move(scene)),
        periods_(periods),
        trials_(count),
        numbers_(count),
        rows_(count * kWidth) {
    if (count == 0 || periods == 0) throw nb::value_error("there must be at least one");
    const auto cores = static_cast<int>(std::thread::hardware_concurrency());
    pool_size_ = std::min(threads > 0 ? threads : std::max(cores, 1), static_cast<int>(count));
    pool_size_ = threads_here(pool_size_);
    pool_ = std::make_unique<WorkerPool>(pool_size_);
  }
  ~Trials() {
    // A process that was forked since has no such threads to end.
    if (threads_here(pool_size_) != pool_size_) static_cast<void>(pool_.release());
  }
  Trials(const Trials&) = delete;
  Trials& operator=(const Trials&) = delete;

  Array reset(std::uint64_t seed, const std::vector<std::uint64_t>& first) {
    if (first.size() != trials_.size()) throw nb::value_error("trials: one for each environment");
    {
      const nb::gil_scoped_release release;
      const std::lock_guard lock(mutex_);
      seed_ = seed;
      for_each([&](std::size_t i) { begin(i, first[i]); });
    }
    return rows();
  }

  // Those of `again` begin their next trial instead of stepping.
  Array step(const Numbers& velocity, const nb::ndarray<const bool, nb::c_contig>& again) {
    const std::size_t count = trials_.size();
    if (velocity.ndim() != 2 || velocity.shape(0) != count || velocity.shape(1) != 5 ||
        again.size() != count)
      throw nb::value_error(("actions: expected shape (" + std::to_string(count) + ", 5)").c_str());
    {
      const nb::gil_scoped_release release;
      const std::lock_guard lock(mutex_);
      if (!trials_[0]) throw std::runtime_error("reset the environments first");
      for_each([&](std::size_t i) {
        if (again.data()[i]) return begin(i, numbers_[i] + count);
        const HandTwist v = Eigen::Map<const HandTwist>(velocity.data() + 5 * i);
        for (std::size_t n = 0; n < periods_ && !trials_[i]->ended(); ++n) trials_[i]->step(v);
        show(i);
      });
    }
    return rows();
  }

  const SteppedTrial& trial(std::size_t i) const {
    if (i >= trials_.size() || !trials_[i]) throw nb::index_error("no such trial");
    return *trials_[i];
  }

 private:
  // On all cores.
  void for_each(const std::function<void(std::size_t)>& work) {
    if (threads_here(pool_size_) > 1) return pool_->for_each(trials_.size(), work);
    for (std::size_t i = 0; i < trials_.size(); ++i) work(i);
  }
  void begin(std::size_t i, std::uint64_t trial) {
    numbers_[i] = trial;
    const std::uint64_t feasible =
        !scene_->drawn.empty() ? feasible_trial(*scene_, seed_, trial).trial : trial;
    trials_[i] = std::make_unique<SteppedTrial>(scene_, seed_, feasible);
    show(i);
  }
  void show(std::size_t i) noexcept {
    const SteppedTrial& t = *trials_[i];
    const Observation& o = t.observation();
    Eigen::Map<Eigen::Matrix<double, kWidth, 1>> row(&rows_[i * kWidth]);
    row << o.wrench, o.depth, o.time, t.wrench(), t.result().state.tip[0],
        t.ended() ? static_cast<double>(t.ended()->outcome) : -1.0, t.summary().peak_force,
        static_cast<double>(numbers_[i]), o.displacement, o.height;
  }
  Array rows() const {
    return array(rows_.data(), {trials_.size(), static_cast<std::size_t>(kWidth)});
  }

  SharedScene scene_;
  std::size_t periods_;
  std::vector<std::unique_ptr<SteppedTrial>> trials_;
  std::vector<std::uint64_t> numbers_;
  std::vector<double> rows_;
  std::uint64_t seed_ = 0;
  int pool_size_ = 1;
  std::unique_ptr<WorkerPool> pool_;
  std::mutex mutex_;
};

void add_observation(nb::module_& module) {
  using O = SceneObservation;
  nb::class_<O>(module, "Observation",
                "What a controller observes, in the hand's world (the tip's, scaled up).")
      .def(
          "__init__",
          [](O* self, nb::handle wrench, double depth, double time) {
            const HandWrench felt = numbers(wrench, 5, "wrench (Fx, Fy, Fz [N], My, Mz [N m])");
            new (self) O{{felt, depth, time}};
          },
          nb::arg("wrench"), nb::arg("depth"), nb::arg("time"))
      .def_prop_ro(
          "wrench", [](const O& o) { return array(o.observed.wrench); }, kOwned,
          "At the holder, relative to that at rest at the start: Fx, Fy, Fz [N], My, Mz [N m]; "
          "shape (5,).")
      .def_prop_ro(
          "depth", [](const O& o) { return o.observed.depth; },
          "Of the hand past the bore's entrance [m], >= 0.")
      .def_prop_ro(
          "displacement", [](const O& o) { return array(o.observed.displacement); }, kOwned,
          "Of the hand since the start: x, y, z [m], tilts about y and z [rad]; shape (5,).")
      .def_prop_ro(
          "height", [](const O& o) { return o.observed.height; },
          "Of the hand before the bore's entrance [m]; < 0 past it.")
      .def_prop_ro(
          "time", [](const O& o) { return o.observed.time; }, "Since the start [s].")
      .def_prop_ro(
          "values",
          [](const O& o) {
            std::vector<double> all;
            for (const ObservationChannel& channel : kObservation)
              all.push_back(channel.value(o.observed));
            return array(all.data(), {all.size()});
          },
          kOwned, "All of it: wrench, depth, time; shape (7,).")
      .def("__repr__", [](const O& o) {
        return "<ferrule.Observation at " + std::to_string(o.observed.time) + " s>";
      });
}

}  // namespace

void add_simulator(nb::module_& module) {
  add_observation(module);
  nb::class_<Simulator>(module, "_Simulator",
                        "One insertion, period by period, with the bits of a trial of the program.")
      .def(nb::init<SharedScene, double>(), nb::arg("scene"), nb::arg("period"))
      .def("reset", &Simulator::reset, nb::arg("seed") = 7, nb::arg("trial") = 0,
           nb::arg("feasible") = false,
           "To the start of trial `trial` of a campaign under `seed`; returns the observation "
           "there.\n`feasible`: where the drawn parts do not fit, the next trial whose do "
           "(trial + 2**32 ...).")
      .def("step", &Simulator::step, nb::arg("velocity").none(), nb::arg("periods") = 1,
           "Moves the hand by `velocity` for so many periods, or until the trial ends; returns "
           "the observation there.\n`velocity`: shape (5,), x y z [m/s] and tilts [rad/s] in the "
           "hand's world, cut to the scene's speed limit.\nOne that is not finite ends the trial "
           "as \"invalid_output\". Raises ValueError for another shape, RuntimeError before a "
           "reset and after the end.")
      .def_prop_ro("scene", &Simulator::scene)
      .def_prop_ro("period", &Simulator::period, "[s]")
      .def_prop_ro("trial", &Simulator::trial_number, "The trial it is at.")
      .def_prop_ro(
          "observation",
          [](const Simulator& s) {
            return s.look([&](const SteppedTrial& t) {
              return SceneObservation{t.observation(), s.scene()};
            });
          },
          "The last one.")
      .def_prop_ro(
          "wrench",
          [](const Simulator& s) {
            return s.look([](const SteppedTrial& t) { return array(t.wrench()); });
          },
          kOwned,
          "As the force sensor reads it, not relative to that at rest: Fx, Fy, Fz [N], My, Mz "
          "[N m] in the hand's world; shape (5,).")
      .def_prop_ro(
          "state",
          [](const Simulator& s) {
            return s.look([](const SteppedTrial& t) { return array(to_row(t.result().state)); });
          },
          kOwned, "The state as an episode's `states` have it, at the tip's scale; shape (42,).")
      .def_prop_ro(
          "tip",
          [](const Simulator& s) {
            return s.look([](const SteppedTrial& t) { return array(t.result().state.tip); });
          },
          kOwned, "Pose of the fibre's end: x, y, z [m], tilt_y, tilt_z [rad]; shape (5,).")
      .def_prop_ro(
          "forces",
          [](const Simulator& s) {
            return s.look([](const SteppedTrial& t) { return force_dict(t); });
          },
          "The force of each term on the fibre, by its name: x, y, z [N]; shape (3,) each.")
      .def_prop_ro(
          "holder_wrench",
          [](const Simulator& s) {
            return s.look([](const SteppedTrial& t) { return array(t.result().holder); });
          },
          kOwned,
          "Of the fibre on its holder, at the tip's scale: Fx, Fy, Fz [N], My, Mz [N m]; shape "
          "(5,).")
      .def_prop_ro(
          "ended",
          [](const Simulator& s) { return s.look([](const SteppedTrial& t) { return ended(t); }); },
          "How the trial ended (\"inserted\", \"force_limit\" ...); None while it goes on.")
      .def_prop_ro(
          "summary",
          [](const Simulator& s) {
            return s.look([](const SteppedTrial& t) { return summary_dict(t.summary()); });
          },
          "Of the trial so far: time_s, peak_force_N, peak_stress_Pa, friction_work_J, depth_m, "
          "offset_m, tilt_rad.");

  nb::class_<Trials>(module, "_Trials")
      .def(nb::init<SharedScene, std::size_t, std::size_t, int>(), nb::arg("scene"),
           nb::arg("count"), nb::arg("periods"), nb::arg("threads"))
      .def("reset", &Trials::reset, nb::arg("seed"), nb::arg("first"))
      .def("step", &Trials::step, nb::arg("velocity"), nb::arg("again"))
      .def("tip",
           [](const Trials& t, std::size_t i) { return array(t.trial(i).result().state.tip); })
      .def("forces", [](const Trials& t, std::size_t i) { return force_dict(t.trial(i)); });
  std::vector<std::string> columns(std::begin(Trials::kColumns), std::end(Trials::kColumns));
  module.attr("_trial_columns") = columns;
  std::vector<std::string> outcomes;
  for (int i = 0; i < kOutcomes; ++i) outcomes.emplace_back(name(static_cast<Outcome>(i)));
  module.attr("outcomes") = outcomes;
}

}  // namespace ferrule::python
