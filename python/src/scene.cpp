// Scenes, and the forces in them.
#include "bindings.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/analysis/gap_forces.hpp"
#include "sim/analysis/plan.hpp"
#include "sim/scene/extends.hpp"
#include "sim/scene/setting.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule::python {
namespace {

// `plan`: as the program runs it, without what its accuracy does not need.
std::shared_ptr<const Scene> made(const Scene& scene, bool plan) {
  const nb::gil_scoped_release release;
  return std::make_shared<const Scene>(plan ? planned(scene) : scene);
}

std::shared_ptr<const Scene> load(const std::filesystem::path& name_or_file,
                                  const std::vector<std::string>& settings, bool plan) {
  return made(load_scene(name_or_file.string(), settings), plan);
}

std::shared_ptr<const Scene> parse(const std::string& document, const std::string& where,
                                   const std::vector<std::string>& settings, bool plan) {
  Json json = whole_scene(scene_layers(parse_json(document, where), where));
  for (const std::string& setting : settings) apply_setting(json, setting);
  const Scene scene = parse_scene(json, where);
  refuse_contradictions(scene, where);
  return made(scene, plan);
}

// Row by row: the terms in their order, then squeeze [N].
Array forces(const Scene& scene, const Numbers& gap_nm, const Numbers& length_um,
             const Numbers& depth_nm, double tilt_mrad, double speed_um_s) {
  const std::size_t rows = gap_nm.size(), width = kTerms + 1;
  std::vector<double> values(rows * width);
  for (std::size_t n = 0; n < rows; ++n) {
    expect_fits(scene.world, gap_nm.data()[n], length_um.data()[n], tilt_mrad);
    const double depth = depth_nm.data()[n];
    Posture posture{1e-9 * gap_nm.data()[n], 1e-6 * length_um.data()[n], std::nullopt,
                    1e-3 * tilt_mrad, 1e-6 * speed_um_s};
    if (!std::isnan(depth)) posture.depth = 1e-9 * depth;
    const GapForces found = gap_forces(scene.world, posture);
    for (const Term term : kAllTerms)
      values[n * width + static_cast<std::size_t>(term)] = found[term];
    values[n * width + kTerms] = found.squeeze;
  }
  return array(values.data(), {rows, width});
}

Array observation_limits(const Scene& s) {
  constexpr double kDeviations = 4;  // of the sensor's errors
  const Holder& holder = s.world.holder;
  Wrench tip = Wrench::Constant(s.limits.force + holder.weight.head<3>().norm() +
                                kDeviations * s.sensor.deviation(s.limits.force, s.limits.time));
  tip.tail<2>() *= s.sensor.arm;
  // The hand is ahead of the end by what the force bends the holder.
  const double depth = s.success.depth + s.limits.force / holder.stiffness(0, 0) +
                       std::abs(s.sensor.entrance_error) + kDeviations * s.sensor.entrance_sd;
  const Scaling scaling = scene_scaling(s);
  Eigen::Matrix<double, 7, 1> limits;
  limits << scaling.wrench_to_hand(tip), scaling.motion * depth, s.limits.time;
  return array(limits);
}

std::vector<std::string> term_names() {
  std::vector<std::string> names;
  for (const Term term : kAllTerms) names.emplace_back(info(term).name);
  return names;
}

}  // namespace

void add_scene(nb::module_& module) {
  nb::class_<Scene>(module, "Scene",
                    "The world, where insertions start, what counts as success, and the scaling "
                    "between hand and tip.\nMade by ferrule.load_scene; does not change.")
      .def_ro("name", &Scene::name)
      .def_prop_ro(
          "json", [](const Scene& s) { return s.document().dump(); },
          "The scene as resolved, a JSON text: loading it gives this scene again.")
      .def_prop_ro(
          "speed_limit", [](const Scene& s) { return s.limits.speed; },
          "Largest speed commanded, at the tip [m/s].")
      .def_prop_ro(
          "force_limit", [](const Scene& s) { return s.limits.force; },
          "Largest force at the holder, weight apart [N].")
      .def_prop_ro(
          "time_limit", [](const Scene& s) { return s.limits.time; }, "Longest trial [s].")
      .def_prop_ro(
          "success_depth", [](const Scene& s) { return s.success.depth; },
          "Inserted length that counts as success [m].")
      .def_prop_ro(
          "start_distance", [](const Scene& s) { return s.start.distance; },
          "Of the fibre's end from the bore at the start [m].")
      .def_prop_ro(
          "observation_limits", &observation_limits, kOwned,
          "The largest size of what is observed before the scene's limits end an insertion: Fx, "
          "Fy, Fz [N], My, Mz [N m] (weight and 4 standard deviations of the sensor included, "
          "moments as that force at the sensor's arm), depth [m], time [s], in the hand's world; "
          "shape (7,).")
      .def_prop_ro(
          "motion_scale", [](const Scene& s) { return scene_scaling(s).motion; },
          "alpha_x: lengths of the hand's world over those of the tip [-].")
      .def_prop_ro(
          "force_scale", [](const Scene& s) { return scene_scaling(s).force; },
          "alpha_f: forces of the hand's world over those of the tip [-].")
      .def_prop_ro(
          "bore_radius", [](const Scene& s) { return s.world.annulus.bore_radius; }, "[m]")
      .def_prop_ro(
          "fibre_radius", [](const Scene& s) { return s.world.annulus.fibre_radius; }, "[m]")
      .def("__repr__", [](const Scene& s) { return "<ferrule.Scene " + s.name + ">"; });
  module.def("_load_scene", &load, nb::arg("name_or_file"), nb::arg("settings"), nb::arg("plan"));
  module.def("_parse_scene", &parse, nb::arg("document"), nb::arg("where"), nb::arg("settings"),
             nb::arg("plan"));
  module.def("_forces", &forces, nb::arg("scene"), nb::arg("gap_nm"), nb::arg("length_um"),
             nb::arg("depth_nm"), nb::arg("tilt_mrad"), nb::arg("speed_um_s"));
  module.def("shipped_scenes", &shipped_scenes, "Names of the scenes that ship, sorted.");
  module.attr("_terms") = term_names();
}

}  // namespace ferrule::python
