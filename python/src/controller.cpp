// Controllers and campaigns of them.
#include <nanobind/stl/tuple.h>

#include "bindings.hpp"
#include "controller/baseline.hpp"
#include "controller/campaign_table.hpp"
#include "controller/supervisor.hpp"
#include "controller/trial_fields.hpp"
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
  PythonController(nb::handle policy, SharedScene scene, std::uint64_t seed, std::uint64_t trial,
                   Failure& failure)
      : policy_(policy), scene_(std::move(scene)), seed_(seed), trial_(trial), failure_(failure) {
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
        return numbers(policy_(SceneObservation{observation, scene_, seed_, trial_}), 5, kAnswer);
      } catch (...) {
        failure_.keep();
      }
    }
    return HandTwist::Constant(std::numeric_limits<double>::quiet_NaN());
  }

 private:
  nb::handle policy_;
  SharedScene scene_;
  std::uint64_t seed_, trial_;
  Failure& failure_;
};

nb::tuple evaluate(nb::handle policy, const SharedScene& scene, std::size_t trials,
                   std::uint64_t seed, bool supervise, int threads) {
  Failure failure;
  MakeController make;
  if (nb::isinstance<LoadedController>(policy)) {
    make = nb::cast<const LoadedController&>(policy).in(*scene, seed);
  } else {
    make = [policy, scene, seed, &failure](std::uint64_t trial) {
      return std::make_unique<PythonController>(policy, scene, seed, trial, failure);
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
  for (const TrialResult& r : results) outcomes.emplace_back(name(r.outcome));
  nb::dict numbers;
  for (const TrialField& field : kTrialFields) {
    std::vector<double> of_each;
    for (const TrialResult& r : results) of_each.push_back(value(field, r));
    std::string key = field.name;
    if (*field.unit) key.append("_").append(field.unit);
    numbers[key.c_str()] = array(of_each.data(), {of_each.size()});
  }
  return nb::make_tuple(to_json(summarise(results)).dump(), outcomes, numbers);
}

nb::object number_or_none(double x) {
  return std::isfinite(x) ? nb::object(nb::float_(x)) : nb::none();
}

// A law's gains by their name; none of a network, or of a controller without a file.
nb::typed<nb::dict, nb::str, nb::typed<nb::dict, nb::str, nb::any>> gains(
    const LoadedController& c) {
  nb::dict all;
  if (!c.read) return all;
  if (const auto* search = std::get_if<SearchFile>(&*c.read))
    for (std::size_t i = 0; i < kSearchGains.size(); ++i) {
      nb::dict gain;
      gain["value"] = search->gains[i];
      gain["unit"] = kSearchGains[i].unit;
      all[kSearchGains[i].name] = gain;
    }
  const auto* law = std::get_if<LawFile>(&*c.read);
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

// An error of its training [m/s]; NaN without a training.
template <class Of>
auto of_file(const Of& of) {
  return [of](const LoadedController& c) {
    return c.read ? std::visit(of, *c.read) : std::numeric_limits<double>::quiet_NaN();
  };
}

std::unique_ptr<LoadedController> load(const std::filesystem::path& name_or_file) {
  const std::string name = name_or_file.string();
  if (is_baseline(name)) return std::make_unique<LoadedController>(name);
  if (name.ends_with(".pt"))
    throw BadInput(name + ": is TorchScript, which the program runs: ferrule evaluate " + name);
  ControllerFile read = read_controller(name);
  return std::make_unique<LoadedController>(std::move(read), controller_file(name));
}

// What its file does not hold: name, other_scaling, report, warnings, residuals.
using MoreOfController =
    std::tuple<std::string, bool, std::string, std::vector<std::string>, double, double>;

MoreOfController more_of(const LoadedController& c) {
  const double residual = of_file([](const auto& f) { return f.residual; })(c);
  const double held_out = of_file([](const auto& f) { return f.held_out_residual; })(c);
  return {c.name, c.other_scaling, c.report, c.warnings, residual, held_out};
}

// From `file` as it was saved; empty for one without a file.
std::unique_ptr<LoadedController> again(const std::optional<std::string>& file,
                                        const MoreOfController& more) {
  auto made = std::make_unique<LoadedController>(std::get<0>(more));
  const double residual = std::get<4>(more), held_out = std::get<5>(more);
  if (file) made->read = read_controller(*file);
  if (made->read)
    std::visit(
        [&](auto& f) {
          f.residual = residual;
          f.held_out_residual = held_out;
        },
        *made->read);
  made->other_scaling = std::get<1>(more);
  made->report = std::get<2>(more);
  made->warnings = std::get<3>(more);
  return made;
}

}  // namespace

HandTwist LoadedController::command(const SceneObservation& o) {
  if (o.scene && read) expect_scaling_of(*o.scene);
  if (!at_work && !read && !o.scene)
    throw BadInput(name +
                   ": wants the observations of a Simulator, whose scene says how fast it is");
  if (!read && o.scene && scene_ != o.scene) reset();  // it is another there
  if (!at_work) at_work = read ? maker(*read)(o.trial) : in(*o.scene, o.seed)(o.trial);
  scene_ = o.scene;
  return at_work->command(o.observed);
}

MakeController LoadedController::in(const Scene& scene, std::uint64_t seed) const {
  if (!read) return baseline(name, scene, seed);
  expect_scaling_of(scene);
  return maker(*read);
}

void LoadedController::expect_scaling_of(const Scene& scene) const {
  if (other_scaling) return;
  const std::string trouble = scaling_trouble(trained_on(*read).scaling, name, scene);
  if (!trouble.empty()) throw BadInput(trouble + "; Controller.other_scaling = True allows it");
}

void add_controller(nb::module_& module) {
  nb::class_<LoadedController>(
      module, "Controller",
      "A learned controller at work: called with an observation every millisecond, it answers a "
      "velocity.\nIt remembers what it observed: reset it for every insertion.")
      .def(
          "__call__",
          [](LoadedController& c, const SceneObservation& o) { return array(c.command(o)); },
          nb::arg("observation"),
          "Velocity of the hand until the next period: x, y, z [m/s], tilt_y, tilt_z [rad/s]; "
          "shape (5,).\nRaises BadInput for an observation of a Simulator whose scene scales the "
          "hand otherwise than those\nthat the controller learned from: see other_scaling.")
      .def("reset", &LoadedController::reset, "Forgets what it observed.")
      .def_prop_ro(
          "scene_json",
          [](const LoadedController& c) -> std::optional<std::string> {
            const Json scene = c.read ? trained_on(*c.read).scene : Json();
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
      .def_prop_ro("_has_file", [](const LoadedController& c) { return c.read.has_value(); })
      .def_prop_ro("_more", &more_of)
      .def(
          "save",
          [](const LoadedController& c, const std::filesystem::path& file) {
            if (!c.read) throw BadInput(c.name + ": is known by its name; it has no file");
            write_controller(file.string(), *c.read);
          },
          nb::arg("file"),
          "Writes controller.json as `ferrule fit` does; a network's weights go beside it. Raises "
          "FileTrouble.");
  module.def(
      "load", &load, nb::arg("file"),
      "The controller of a file that `ferrule fit` wrote; a shipped one by its name (search, "
      "tuned_by_hand); or one\nwithout a file, for the scene that it observes: "
      "constant-velocity, spiral, searching-operator. Raises BadInput, FileTrouble.");
  module.def("_controller_again", &again, nb::arg("file").none(), nb::arg("more"));
  module.def("_evaluate", &evaluate, nb::arg("policy"), nb::arg("scene"), nb::arg("trials"),
             nb::arg("seed"), nb::arg("supervise"), nb::arg("threads"));
}

}  // namespace ferrule::python
