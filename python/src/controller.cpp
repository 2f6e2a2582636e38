// Controllers and campaigns of them.
#include "bindings.hpp"
#include "controller/campaign_table.hpp"
#include "controller/supervisor.hpp"
#include "insertion/scene_scaling.hpp"

namespace ferrule::python {
namespace {

constexpr const char* kAnswer =
    "what the policy answered: a velocity (x, y, z [m/s], tilt_y, tilt_z [rad/s], of the hand)";

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
  PythonController(nb::handle policy, SharedScene scene, Failure& failure)
      : policy_(policy), scene_(std::move(scene)), failure_(failure) {
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
        return numbers(policy_(SceneObservation{observation, scene_}), 5, kAnswer);
      } catch (...) {
        failure_.keep();
      }
    }
    return HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
  }

 private:
  nb::handle policy_;
  SharedScene scene_;
  Failure& failure_;
};

nb::tuple evaluate(nb::handle policy, const SharedScene& scene, std::size_t trials,
                   std::uint64_t seed, bool supervise, int threads) {
  const Scaling scaling = scene_scaling(*scene);
  Failure failure;
  MakeController make;
  if (nb::isinstance<LoadedController>(policy)) {
    const auto& controller = nb::cast<const LoadedController&>(policy);
    controller.expect_scaling_of(*scene);
    make = maker(controller.read);
  } else if (nb::isinstance<nb::str>(policy)) {
    make = controller_maker(ConstantVelocity(scaling.motion * scene->limits.speed));
  } else {
    make = [policy, scene, &failure](std::uint64_t) {
      return std::make_unique<PythonController>(policy, scene, failure);
    };
    threads = 1;
  }
  if (supervise) make = supervised(make, supervisor_limits(*scene));
  std::vector<TrialResult> results;
  Interrupts interrupts;
  {
    const nb::gil_scoped_release release;
    results = run_campaign(*scene, make, seed, trials, threads_here(threads), {},
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

nb::object number_or_none(double x) {
  return std::isfinite(x) ? nb::object(nb::float_(x)) : nb::none();
}

// A law's gains by their name; none of a network.
nb::typed<nb::dict, nb::str, nb::typed<nb::dict, nb::str, nb::any>> gains(
    const LoadedController& c) {
  nb::dict all;
  if (const auto* search = std::get_if<SearchFile>(&c.read))
    for (std::size_t i = 0; i < kSearchGains.size(); ++i) {
      nb::dict gain;
      gain["value"] = search->gains[i];
      gain["unit"] = kSearchGains[i].unit;
      all[kSearchGains[i].name] = gain;
    }
  const auto* law = std::get_if<LawFile>(&c.read);
  for (std::size_t i = 0; law && i < law->gains.size(); ++i) {
    const Gain& gain = gain_of(law->kind, i);
    nb::dict fitted;
    fitted["value"] = law->gains[i].value;
    fitted["low"] = number_or_none(law->gains[i].low);
    fitted["high"] = number_or_none(law->gains[i].high);
    fitted["unit"] = gain.unit;
    all[gain.name] = fitted;
  }
  return all;
}

template <class Of>
auto of_file(const Of& of) {
  return [of](const LoadedController& c) { return std::visit(of, c.read); };
}

}  // namespace

void LoadedController::expect_scaling_of(const Scene& scene) const {
  if (other_scaling) return;
  const std::string trouble = scaling_trouble(trained_on(read).scaling, name, scene);
  if (!trouble.empty()) throw BadInput(trouble + "; Controller.other_scaling = True allows it");
}

void add_controller(nb::module_& module) {
  nb::class_<LoadedController>(
      module, "Controller",
      "A learned controller at work: called with an observation every millisecond, it answers a "
      "velocity.\nIt remembers what it observed: reset it for every insertion.")
      .def(
          "__call__",
          [](LoadedController& c, const SceneObservation& o) {
            if (o.scene) c.expect_scaling_of(*o.scene);
            return array(c.at_work->command(o.observed));
          },
          nb::arg("observation"),
          "Velocity of the hand until the next period: x, y, z [m/s], tilt_y, tilt_z [rad/s]; "
          "shape (5,).\nRaises BadInput for an observation of a Simulator whose scene scales the "
          "hand otherwise than those\nthat the controller learned from: see other_scaling.")
      .def("reset", &LoadedController::reset, "Forgets what it observed.")
      .def_prop_ro(
          "scene_json",
          [](const LoadedController& c) -> std::optional<std::string> {
            const Json& scene = trained_on(c.read).scene;
            if (scene.is_null()) return std::nullopt;
            return scene.dump();
          },
          "The scene it was trained on, a JSON text; None where its file holds no single one.")
      .def_rw("other_scaling", &LoadedController::other_scaling,
              "Whether it may drive a scene that scales the hand otherwise than those that it "
              "learned from; False at first.")
      .def_prop_ro("gains", &gains,
                   "Of a law, by name: {\"value\", \"low\", \"high\", \"unit\"}, with the 95 % "
                   "interval, None where the data leave it open. Empty for a network.")
      .def_prop_ro("residual", of_file([](const auto& c) { return c.residual; }),
                   "Root mean square error of the velocity on the episodes of its training, "
                   "hand's world [m/s].")
      .def_prop_ro("held_out_residual", of_file([](const auto& c) { return c.held_out_residual; }),
                   "The same on the episodes that were held out [m/s].")
      .def_ro("report", &LoadedController::report,
              "The lines of `ferrule fit`, where ferrule.fit made it; else empty.")
      .def_ro("warnings", &LoadedController::warnings,
              "What `ferrule fit` warns of, a line each, where ferrule.fit made it; else empty.")
      .def(
          "save",
          [](const LoadedController& c, const std::filesystem::path& file) {
            write_controller(file.string(), c.read);
          },
          nb::arg("file"),
          "Writes controller.json as `ferrule fit` does; a network's weights go beside it. Raises "
          "FileTrouble.");
  module.def(
      "load",
      [](const std::filesystem::path& name_or_file) {
        const std::string file = controller_file(name_or_file.string());
        return std::make_unique<LoadedController>(read_controller(file), file);
      },
      nb::arg("file"),
      "The controller of a file that `ferrule fit` wrote, or a shipped one by its name. Raises "
      "BadInput, FileTrouble.");
  module.def("_evaluate", &evaluate, nb::arg("policy"), nb::arg("scene"), nb::arg("trials"),
             nb::arg("seed"), nb::arg("supervise"), nb::arg("threads"));
}

}  // namespace ferrule::python
