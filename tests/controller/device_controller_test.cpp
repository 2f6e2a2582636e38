#include "controller/device_controller.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

// An operator who is tried on a trial does what he does when it is recorded.
TEST(DeviceController, AnOperatorDoesInATrialWhatIsRecordedOfHim) {
  const testing::TemporaryFolder folder;
  for (const char* name : {"demo", "bench"}) {
    const Scene scene = load_scene(name);
    const std::uint64_t trial = 3;
    const Episode episode = read_episode(testing::record(scene, folder.path(), trial));
    DeviceController controller(
        simulated_operator(scene, draw_start(scene, 1, trial), 0.8, 1e-3, 1, trial), 1e-3);
    const Scaling scaling = scene_scaling(scene);
    State state = draw_start(scene, 1, trial);
    ForceSensor sensor(scene.sensor, 1, trial);
    HandPose pose = scaling.motion_to_hand(state.command);
    HandWrench at_rest;
    for (Eigen::Index n = 0; n + 1 < std::min<Eigen::Index>(episode.rows.rows(), 12000); ++n) {
      const StepResult r =
          step(scene.world, state, scaling.motion_to_tip(pose), n == 0 ? 0.0 : 1e-3);
      state = r.state;
      const HandWrench felt = scaling.wrench_to_hand(sensor.read(r.forces.holder, 1e-3));
      if (n == 0) at_rest = felt;
      const HandTwist v =
          controller.command({felt - at_rest, hand_depth(pose), static_cast<double>(n) * 1e-3});
      const HandTwist recorded = episode.rows.row(n).segment<5>(kCommand.begin).transpose();
      ASSERT_LE((v - recorded).norm(), 1e-9) << name << " row " << n;
      pose += 1e-3 * v;
    }
    std::filesystem::remove(episode_files(folder.path()).front());
  }
}

}  // namespace
}  // namespace ferrule
