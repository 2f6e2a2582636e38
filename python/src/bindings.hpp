// What the parts of the Python module share. Docstrings are the specification of the package: units
// [..], shapes, what is raised.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/function.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "controller/controller_file.hpp"
#include "sim/scene/scene.hpp"

namespace ferrule::python {

namespace nb = nanobind;
using Array = nb::ndarray<nb::numpy, double>;
using Numbers = nb::ndarray<const double, nb::c_contig, nb::device::cpu>;
using SharedScene = std::shared_ptr<const Scene>;

// How a property returns an array: it has an owner, and is not copied.
inline constexpr auto kOwned = nb::rv_policy::reference;

void add_scene(nb::module_& module);
void add_simulator(nb::module_& module);
void add_controller(nb::module_& module);
void add_episode(nb::module_& module);
void add_learning(nb::module_& module);

// What a controller observes, and the scene and the trial it does so in: null where somebody made it.
struct SceneObservation {
  Observation observed;
  SharedScene scene{};
  std::uint64_t seed = 0, trial = 0;
};

// A controller at work, and what makes it anew for every trial.
struct LoadedController {
  // `called`: its file, for messages.
  LoadedController(ControllerFile file, std::string called)
      : read(std::move(file)), name(std::move(called)) {}
  // One without a file (controller/baseline.hpp).
  explicit LoadedController(std::string baseline) : name(std::move(baseline)) {}

  void reset() { at_work.reset(); }
  HandTwist command(const SceneObservation& o);
  // In trials of `scene` under `seed`. Throws BadInput, as the program does, where the scene scales
  // the hand otherwise than those that it learned from, unless that is allowed.
  MakeController in(const Scene& scene, std::uint64_t seed) const;

  std::optional<ControllerFile> read;  // empty: `name` is that of a baseline
  std::string name;
  bool other_scaling = false;
  std::string report;                     // of its fit
  std::vector<std::string> warnings;      // of its fit
  std::unique_ptr<Controller> at_work{};  // null until it is asked

 private:
  void expect_scaling_of(const Scene& scene) const;
  SharedScene scene_;  // of what it was asked last
};

// Ctrl-C where C++ runs: handled by the thread that called.
class Interrupts {
 public:
  bool operator()() {
    if (!seen_ && std::this_thread::get_id() == caller_) {
      const nb::gil_scoped_acquire acquire;
      seen_ = PyErr_CheckSignals() != 0;
      if (seen_) raised_ = std::make_exception_ptr(nb::python_error());
    }
    return seen_;
  }
  void rethrow() const {
    if (raised_) std::rethrow_exception(raised_);
  }

 private:
  std::thread::id caller_ = std::this_thread::get_id();
  std::atomic<bool> seen_ = false;
  std::exception_ptr raised_;
};

// `count` numbers of any sequence or array; ValueError "WHAT: ..." where it is something else.
Eigen::VectorXd numbers(nb::handle from, Eigen::Index count, const char* what);
// A new array.
Array array(const double* values, std::vector<std::size_t> shape);
template <class Vector>
Array array(const Vector& values) {
  return array(values.data(), {static_cast<std::size_t>(values.size())});
}

// So many threads, or as many as there are cores: for 0, and where there are fewer. In a process that
// was forked the threads are gone: everything runs on one thread there.
int threads_here(int threads) noexcept;

}  // namespace ferrule::python
