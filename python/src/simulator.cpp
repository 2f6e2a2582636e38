// Stepping: one trial period by period, and many at once.
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <mutex>

#include "bindings.hpp"
#include "controller/stepped_trial.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/terms.hpp"
#include "worker_pool.hpp"

namespace ferrule::python {
namespace {

constexpr const char* kVelocity = "velocity (x, y, z [m/s], tilt_y, tilt_z [rad/s], of the hand)";

// A trial from its start to where it is: what was told to go there makes it again, bit for bit.
class Course {
 public:
  static constexpr std::size_t kWidth = 6;  // velocity [m/s, rad/s], and how many periods

  Course() = default;
  // At the start of the trial, or where the drawn parts do not fit and `feasible`, of the next
  // whose do.
  Course(SharedScene scene, std::uint64_t seed, std::uint64_t trial, bool feasible, double period)
      : scene_(std::move(scene)), seed_(seed), number_(trial) {
    if (feasible && !scene_->drawn.empty()) number_ = feasible_trial(*scene_, seed, trial).trial;
    trial_ = std::make_unique<SteppedTrial>(scene_, seed, number_, period);
  }
  explicit operator bool() const noexcept { return trial_ != nullptr; }

  void step(const HandTwist& velocity, std::size_t periods) {
    for (std::size_t n = 0; n < periods && !trial_->ended(); ++n) trial_->step(velocity);
    if (told_.empty() || told_.back().first != velocity)
      told_.emplace_back(velocity, periods);
    else
      told_.back().second += periods;
  }
  const SteppedTrial& trial() const noexcept { return *trial_; }
  std::uint64_t seed() const noexcept { return seed_; }
  std::uint64_t number() const noexcept { return number_; }

  // Of scene, seed, trial, and rows of what was told.
  using Kept = std::tuple<SharedScene, std::uint64_t, std::uint64_t, Array>;
  Kept kept() const {
    std::vector<double> rows;
    for (const auto& [velocity, periods] : told_) {
      rows.insert(rows.end(), velocity.begin(), velocity.end());
      rows.push_back(static_cast<double>(periods));
    }
    return {scene_, seed_, number_, array(rows.data(), {told_.size(), kWidth})};
  }
  using Told = std::tuple<SharedScene, std::uint64_t, std::uint64_t, Numbers>;
  static Course of(const Told& kept, double period) {
    const auto& [scene, seed, number, told] = kept;
    if (told.ndim() != 2 || told.shape(1) != kWidth) throw nb::value_error("no course of a trial");
    Course course(scene, seed, number, false, period);
    for (std::size_t n = 0; n < told.shape(0); ++n) {
      const double* const row = told.data() + kWidth * n;
      course.step(Eigen::Map<const HandTwist>(row), static_cast<std::size_t>(row[kWidth - 1]));
    }
    return course;
  }

 private:
  SharedScene scene_;
  std::uint64_t seed_ = 0, number_ = 0;
  std::unique_ptr<SteppedTrial> trial_;
  std::vector<std::pair<HandTwist, std::size_t>> told_;
};

// A trial that several Python threads may hold: one at a time.
class Simulator {
 public:
  Simulator(SharedScene scene, double period) : scene_(std::move(scene)), period_(period) {
    if (!(period > 0 && period <= 1)) throw nb::value_error("period: must be above 0, at most 1 s");
  }

  SceneObservation reset(std::uint64_t seed, std::uint64_t trial, bool feasible) {
    const nb::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    course_ = Course(scene_, seed, trial, feasible, period_);
    return observation();
  }

  SceneObservation step(nb::handle velocity, std::size_t periods) {
    const HandTwist v = numbers(velocity, 5, kVelocity);
    const nb::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    const SteppedTrial& trial = running();
    if (trial.ended())
      throw std::runtime_error("the trial has ended (" + std::string(name(trial.ended()->outcome)) +
                               "): reset the simulator first");
    course_.step(v, periods);
    return observation();
  }
  SceneObservation observation() const {
    return {running().observation(), scene_, course_.seed(), course_.number()};
  }

  // What is asked for between steps.
  const SteppedTrial& running() const {
    if (!course_) throw std::runtime_error("the simulator is at no trial: reset it first");
    return course_.trial();
  }
  template <class Of>
  auto look(const Of& of) const {
    const std::lock_guard lock(mutex_);
    return of(running());
  }
  const SharedScene& scene() const noexcept { return scene_; }
  double period() const noexcept { return period_; }
  std::uint64_t trial_number() const noexcept { return course_.number(); }

  std::optional<Course::Kept> kept() const {
    const std::lock_guard lock(mutex_);
    return course_ ? std::optional(course_.kept()) : std::nullopt;
  }
  void resume(const Course::Told& kept) {
    const nb::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    const auto& [scene, seed, number, told] = kept;
    course_ = Course::of({scene_, seed, number, told}, period_);  // it keeps the scene alive
  }

 private:
  SharedScene scene_;
  double period_;
  Course course_;
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

// N trials side by side, each of its own scene and seed. A row of what each is observed and came to,
// kWidth numbers.
class Trials {
 public:
  static constexpr int kWidth = 25;
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
                                             "tip_y",
                                             "tip_z",
                                             "tip_tilt_y",
                                             "tip_tilt_z",
                                             "outcome",
                                             "peak_force",
                                             "displacement_x",
                                             "displacement_y",
                                             "displacement_z",
                                             "displacement_tilt_y",
                                             "displacement_tilt_z",
                                             "height"};
  using Flags = nb::ndarray<const bool, nb::ndim<1>, nb::c_contig, nb::device::cpu>;
  using Wholes = nb::ndarray<const std::uint64_t, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

  Trials(std::size_t count, std::size_t periods, int threads)
      : periods_(periods), courses_(count), rows_(count * kWidth) {
    if (count == 0 || periods == 0) throw nb::value_error("there must be at least one");
    pool_size_ = std::min<int>(threads_here(threads), static_cast<int>(count));
    pool_ = std::make_unique<WorkerPool>(pool_size_);
  }
  ~Trials() {
    // A process that was forked since has no such threads to end.
    if (threads_here(pool_size_) != pool_size_) static_cast<void>(pool_.release());
  }
  Trials(const Trials&) = delete;
  Trials& operator=(const Trials&) = delete;

  // Those of `which` begin these trials under these seeds, in `scene`.
  Array reset(const Flags& which, const SharedScene& scene, const Wholes& seeds,
              const Wholes& trials) {
    expect_each({which.size(), seeds.size(), trials.size()});
    {
      const nb::gil_scoped_release release;
      const std::lock_guard lock(mutex_);
      for_each([&](std::size_t i) {
        if (which.data()[i]) begin(i, scene, seeds.data()[i], trials.data()[i]);
      });
    }
    return rows();
  }

  // The same for those of `again`; the others go their way.
  Array step(const Numbers& velocity, const Flags& again, const SharedScene& scene,
             const Wholes& seeds, const Wholes& trials) {
    expect_each({velocity.size() / 5, again.size(), seeds.size(), trials.size()});
    if (!std::all_of(courses_.begin(), courses_.end(),
                     [](const Course& c) { return static_cast<bool>(c); }))
      throw std::runtime_error("reset the environments first");
    {
      const nb::gil_scoped_release release;
      const std::lock_guard lock(mutex_);
      for_each([&](std::size_t i) {
        if (again.data()[i]) return begin(i, scene, seeds.data()[i], trials.data()[i]);
        courses_[i].step(Eigen::Map<const HandTwist>(velocity.data() + 5 * i), periods_);
        show(i);
      });
    }
    return rows();
  }

  const Course& course(std::size_t i) const {
    if (i >= courses_.size() || !courses_[i]) throw nb::index_error("no such trial");
    return courses_[i];
  }
  nb::ndarray<nb::numpy, std::uint64_t> numbers() const {
    using All = std::vector<std::uint64_t>;
    auto all = std::make_unique<All>();
    for (const Course& c : courses_) all->push_back(c.number());
    std::uint64_t* const first = all->data();
    const nb::capsule owner(
        all.get(), [](void* p) noexcept { std::default_delete<All>()(static_cast<All*>(p)); });
    all.release();  // it is the capsule's from here on
    return {first, {courses_.size()}, owner};
  }

  std::vector<Course::Kept> kept() const {
    std::vector<Course::Kept> all;
    for (std::size_t i = 0; i < courses_.size(); ++i) all.push_back(course(i).kept());
    return all;
  }
  void resume(const std::vector<Course::Told>& kept) {
    expect_each({kept.size()});
    const nb::gil_scoped_release release;
    const std::lock_guard lock(mutex_);
    for_each([&](std::size_t i) {
      courses_[i] = Course::of(kept[i], kControlPeriod);
      show(i);
    });
  }

 private:
  void expect_each(std::initializer_list<std::size_t> sizes) const {
    for (const std::size_t size : sizes)
      if (size != courses_.size()) throw nb::value_error("one for each environment");
  }
  // On all cores.
  void for_each(const std::function<void(std::size_t)>& work) {
    if (threads_here(pool_size_) > 1) return pool_->for_each(courses_.size(), work);
    for (std::size_t i = 0; i < courses_.size(); ++i) work(i);
  }
  void begin(std::size_t i, const SharedScene& scene, std::uint64_t seed, std::uint64_t trial) {
    courses_[i] = Course(scene, seed, trial, true, kControlPeriod);
    show(i);
  }
  void show(std::size_t i) noexcept {
    const SteppedTrial& t = courses_[i].trial();
    const Observation& o = t.observation();
    Eigen::Map<Eigen::Matrix<double, kWidth, 1>> row(&rows_[i * kWidth]);
    row << o.wrench, o.depth, o.time, t.wrench(), t.result().state.tip,
        t.ended() ? static_cast<double>(t.ended()->outcome) : -1.0, t.summary().peak_force,
        o.displacement, o.height;
  }
  Array rows() const {
    return array(rows_.data(), {courses_.size(), static_cast<std::size_t>(kWidth)});
  }

  std::size_t periods_;
  std::vector<Course> courses_;
  std::vector<double> rows_;
  int pool_size_ = 1;
  std::unique_ptr<WorkerPool> pool_;
  std::mutex mutex_;
};

// Of an observation, in other processes: wrench, depth, time, displacement, height, force limit;
// the scene, the seed and the trial.
using ObservationState =
    std::tuple<std::vector<double>, std::optional<SharedScene>, std::uint64_t, std::uint64_t>;

ObservationState observation_state(const SceneObservation& o) {
  const Observation& seen = o.observed;
  std::vector<double> values(seen.wrench.begin(), seen.wrench.end());
  values.insert(values.end(), {seen.depth, seen.time});
  values.insert(values.end(), seen.displacement.begin(), seen.displacement.end());
  values.insert(values.end(), {seen.height, seen.force_limit});
  return {values, o.scene ? std::optional(o.scene) : std::nullopt, o.seed, o.trial};
}

void set_observation_state(SceneObservation& o, const ObservationState& state) {
  const auto& [values, scene, seed, trial] = state;
  if (values.size() != 14) throw nb::value_error("no state of an observation");
  const double* const v = values.data();
  new (&o) SceneObservation{{Eigen::Map<const HandWrench>(v), v[5], v[6],
                             Eigen::Map<const HandPose>(v + 7), v[12], v[13]},
                            scene.value_or(nullptr),
                            seed,
                            trial};
}

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
      .def("__getstate__", &observation_state)
      .def("__setstate__", &set_observation_state)
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
      .def("_kept", &Simulator::kept)
      .def("_resume", &Simulator::resume, nb::arg("kept"))
      .def_prop_ro("scene", &Simulator::scene)
      .def_prop_ro("period", &Simulator::period, "[s]")
      .def_prop_ro("trial", &Simulator::trial_number, "The trial it is at.")
      .def_prop_ro(
          "observation",
          [](const Simulator& s) {
            return s.look([&](const SteppedTrial&) { return s.observation(); });
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
          kOwned, "The state as a row of an episode's `states` has it, at the tip's scale.")
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
      .def(nb::init<std::size_t, std::size_t, int>(), nb::arg("count"), nb::arg("periods"),
           nb::arg("threads"))
      .def("reset", &Trials::reset, nb::arg("which"), nb::arg("scene"), nb::arg("seeds"),
           nb::arg("trials"))
      .def("step", &Trials::step, nb::arg("velocity"), nb::arg("again"), nb::arg("scene"),
           nb::arg("seeds"), nb::arg("trials"))
      .def("numbers", &Trials::numbers)
      .def("kept", &Trials::kept)
      .def("resume", &Trials::resume, nb::arg("kept"));
  std::vector<std::string> columns(std::begin(Trials::kColumns), std::end(Trials::kColumns));
  module.attr("_trial_columns") = columns;
  std::vector<std::string> outcomes;
  for (int i = 0; i < kOutcomes; ++i) outcomes.emplace_back(name(static_cast<Outcome>(i)));
  module.attr("outcomes") = outcomes;
}

}  // namespace ferrule::python
