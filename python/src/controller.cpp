// Controllers and campaigns of them.
#include <thread>

#include "bindings.hpp"
#include "controller/campaign_table.hpp"
#include "controller/controller_file.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule::python {
namespace {

using SharedScene = std::shared_ptr<const Scene>;

constexpr const char* kAnswer =
    "what the policy answered: a velocity (x, y, z [m/s], tilt_y, tilt_z [rad/s], of the hand)";

// A controller of a file at work, and what makes it anew for every trial.
struct LoadedController {
  explicit LoadedController(const std::string& file) : read(read_controller(file)) { reset(); }
  void reset() { at_work = maker(read)(0); }
  ControllerFile read;
  std::unique_ptr<Controller> at_work;
};

// What the first policy in Python that failed raised; from then on no trial counts.
struct Failure {
  std::exception_ptr raised;
  void keep() noexcept {
    if (!raised) raised = std::current_exception();
  }
};

// A Python callable at a controller's place.
class PythonController : public Controller {
 public:
  PythonController(nb::handle policy, Failure& failure) : policy_(policy), failure_(failure) {
    const nb::gil_scoped_acquire acquire;
    try {
      if (nb::hasattr(policy_, "reset")) policy_.attr("reset")();
    } catch (...) {
      failure_.keep();
    }
  }
  HandTwist command(const Observation& observation) noexcept override {
    if (!failure_.raised) {
      const nb::gil_scoped_acquire acquire;
      try {
        return numbers(policy_(observation), 5, kAnswer);
      } catch (...) {
        failure_.keep();
      }
    }
    return HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
  }

 private:
  nb::handle policy_;
  Failure& failure_;
};

// Ctrl-C where C++ runs: handled by the thread that called, which takes part in every campaign.
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

nb::tuple evaluate(nb::handle policy, const SharedScene& scene, std::size_t trials,
                   std::uint64_t seed, bool supervise, int threads) {
  const Scaling scaling = scene_scaling(*scene);
  Failure failure;
  MakeController make;
  if (nb::isinstance<LoadedController>(policy)) {
    make = maker(nb::cast<const LoadedController&>(policy).read);
  } else if (nb::isinstance<nb::str>(policy)) {
    make = controller_maker(ConstantVelocity(scaling.motion * scene->limits.speed));
  } else {
    make = [policy, &failure](std::uint64_t) {
      return std::make_unique<PythonController>(policy, failure);
    };
    threads = 1;
  }
  if (supervise) make = supervised(make, supervisor_limits(*scene, scaling));
  std::vector<TrialResult> results;
  Interrupts interrupts;
  {
    const nb::gil_scoped_release release;
    results = run_campaign(*scene, scaling, make, seed, trials, threads_here(threads), {},
                           [&] { return failure.raised || interrupts(); });
  }
  if (failure.raised) std::rethrow_exception(failure.raised);
  interrupts.rethrow();
  std::vector<std::string> outcomes;
  std::vector<double> time, force, loss;
  for (const TrialResult& r : results) {
    outcomes.emplace_back(name(r.outcome));
    time.push_back(r.summary.time);
    force.push_back(r.summary.peak_force);
    loss.push_back(r.loss_dB);
  }
  return nb::make_tuple(to_json(summarise(results)).dump(), outcomes,
                        array(time.data(), {time.size()}), array(force.data(), {force.size()}),
                        array(loss.data(), {loss.size()}));
}

}  // namespace

void add_controller(nb::module_& module) {
  nb::class_<LoadedController>(
      module, "Controller",
      "A learned controller at work: called with an observation every millisecond, it answers a "
      "velocity.\nIt remembers what it observed: reset it for every insertion.")
      .def(
          "__call__",
          [](LoadedController& c, const Observation& o) { return array(c.at_work->command(o)); },
          nb::arg("observation"),
          "Velocity of the hand until the next period: x, y, z [m/s], tilt_y, tilt_z [rad/s]; "
          "shape (5,).")
      .def("reset", &LoadedController::reset, "Forgets what it observed.")
      .def_prop_ro(
          "scene_json",
          [](const LoadedController& c) -> std::optional<std::string> {
            const Json& scene = trained_on(c.read).scene;
            if (scene.is_null()) return std::nullopt;
            return scene.dump();
          },
          "The scene it was trained on, a JSON text; None where its file holds no single one.");
  module.def(
      "load", [](const std::string& file) { return std::make_unique<LoadedController>(file); },
      nb::arg("file"),
      "The controller of a file that `ferrule fit` wrote. Raises BadInput, FileTrouble.");
  module.def("_evaluate", &evaluate, nb::arg("policy"), nb::arg("scene"), nb::arg("trials"),
             nb::arg("seed"), nb::arg("supervise"), nb::arg("threads"));
}

}  // namespace ferrule::python
