// Recorded episodes, as views of their rows.
#include "capture/episode.hpp"

#include <nanobind/stl/tuple.h>

#include "bindings.hpp"
#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule::python {
namespace {

struct ReadEpisode {
  explicit ReadEpisode(const std::filesystem::path& place) {
    const nb::gil_scoped_release release;
    const std::string file = place.string();
    episode = read_episode(file);
    const Scene scene = recorded_scene(episode.info, file);
    sensed = sensed_wrench(episode, scene);
    phases = phases_of(episode.info, episode.rows.rows(), file);
    const auto pose = episode.rows.middleCols<kPose>(kHandPose.begin);
    height = pose.col(0).array() - registered_entrance(scene);
    depth = (-height).cwiseMax(0.0);
    if (pose.rows() > 0) displacement = pose.rowwise() - pose.row(0);
  }
  Episode episode;
  SensedRows sensed;
  std::vector<PhaseBegin> phases;
  Eigen::VectorXd depth, height;
  Eigen::Matrix<double, Eigen::Dynamic, kPose> displacement;
};

using View = nb::ndarray<nb::numpy, const double>;

// Columns of a matrix, not copied: they keep the episode alive.
View view(const double* first, Eigen::Index rows, int width, std::int64_t row_stride,
          std::int64_t column_stride, nb::handle owner) {
  const std::size_t shape[] = {static_cast<std::size_t>(rows), static_cast<std::size_t>(width)};
  const std::int64_t strides[] = {row_stride, column_stride};
  return {first, width == 1 ? 1U : 2U, shape, owner, strides};
}

View block_view(const ReadEpisode& e, const Block& b) {
  const Rows& rows = e.episode.rows;
  return view(rows.data() + b.begin, rows.rows(), b.width, kRowSize, 1, nb::find(e));
}

View sensed_view(const ReadEpisode& e, const Eigen::Matrix<double, Eigen::Dynamic, 5>& m) {
  return view(m.data(), m.rows(), 5, 1, m.rows(), nb::find(e));
}

}  // namespace

void add_episode(nb::module_& module) {
  module.def(
      "_episode_files",
      [](const std::filesystem::path& folder) {
        const std::vector<std::string> files = episode_files(folder.string());
        return std::vector<std::filesystem::path>(files.begin(), files.end());
      },
      nb::arg("folder"));
  nb::class_<ReadEpisode> type(
      module, "_Episode",
      "A recorded insertion. Its arrays are views of its rows: not copied, not to be written to.");
  type.def(nb::init<const std::filesystem::path&>(), nb::arg("file"))
      .def("__len__", [](const ReadEpisode& e) { return e.episode.rows.rows(); })
      .def_prop_ro(
          "scene_json", [](const ReadEpisode& e) { return e.episode.info.scene; },
          "The scene it was recorded in, a JSON text.")
      .def_prop_ro(
          "undrawn_scene_json",
          [](const ReadEpisode& e) { return undrawn(parse_json(e.episode.info.scene, "")).dump(); },
          "The same with the parts as they come: what its parts were drawn from.")
      .def_prop_ro(
          "operator", [](const ReadEpisode& e) { return e.episode.info.operator_; },
          "Who held the fibre.")
      .def_prop_ro("outcome",
                   [](const ReadEpisode& e) { return std::string(name(e.episode.info.outcome)); })
      .def_prop_ro("seed", [](const ReadEpisode& e) { return e.episode.info.seed; })
      .def_prop_ro("trial", [](const ReadEpisode& e) { return e.episode.info.trial; })
      .def_prop_ro(
          "period", [](const ReadEpisode& e) { return e.episode.info.period; }, "[s]")
      .def_prop_ro(
          "wrench", [](const ReadEpisode& e) { return sensed_view(e, e.sensed.absolute); }, kOwned,
          "As the force sensor read it: Fx, Fy, Fz [N], My, Mz [N m] in the hand's world; at rest "
          "that is the weight. Shape (N, 5).")
      .def_prop_ro(
          "relative_wrench", [](const ReadEpisode& e) { return sensed_view(e, e.sensed.relative); },
          kOwned,
          "The same relative to that at rest at the start: what a controller observes. Shape "
          "(N, 5).")
      .def_prop_ro(
          "depth",
          [](const ReadEpisode& e) {
            return view(e.depth.data(), e.depth.size(), 1, 1, 0, nb::find(e));
          },
          kOwned,
          "Of the hand past where it takes the entrance to be, as a controller observes it [m], >= "
          "0, hand's world; shape (N,).")
      .def_prop_ro(
          "height",
          [](const ReadEpisode& e) {
            return view(e.height.data(), e.height.size(), 1, 1, 0, nb::find(e));
          },
          kOwned, "Of the hand before that entrance [m]; < 0 past it. Shape (N,).")
      .def_prop_ro(
          "displacement", [](const ReadEpisode& e) { return sensed_view(e, e.displacement); },
          kOwned,
          "Of the hand since the start: x, y, z [m], tilts about y and z [rad], hand's world. "
          "Shape "
          "(N, 5).")
      .def_prop_ro(
          "phases",
          [](const ReadEpisode& e) {
            std::vector<std::tuple<Eigen::Index, std::string>> all;
            for (const PhaseBegin& p : e.phases) all.emplace_back(p.row, p.name);
            return all;
          },
          "What the operator was at, where it says so: (first row, name) of each.");
  const auto add = [&](const char* name, const Block& b, const char* doc) {
    type.def_prop_ro(
        name, [&b](const ReadEpisode& e) { return block_view(e, b); }, kOwned, doc);
  };
  add("time", kTime, "t_n [s], shape (N,).");
  add("hand_pose", kHandPose, "x, y, z [m], tilt_y, tilt_z [rad] in the hand's world; (N, 5).");
  add("hand_velocity", kHandVelocity, "Over [t_n-1, t_n) [m/s, rad/s], hand's world; (N, 5).");
  add("command", kCommand,
      "Velocity of the hand over [t_n, t_n+1): what it answers to the force of the same row "
      "[m/s, rad/s], hand's world; (N, 5).");
  add("holder_wrench", kHolder, "Of the fibre on the hand [N, N m], at the tip's scale; (N, 5).");
  add("forces", kForces,
      "x y z [N] of each of ferrule.terms, at the tip's scale; (N, 3 len(terms)).");
  add("status", kStatus, "0 ok, 1 not converged, 2 bad command, 3 capped; (N,).");
  add("states", kStates,
      "The simulator's state, at the tip's scale: the columns of the file's `states`.");
}

}  // namespace ferrule::python
