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
    DeviceController controller(simulated_operator(testing::setup(scene, trial), 0.8), 1e-3);
    const State start = draw_start(scene, 1, trial);
    ControllerHand hand(controller, scene_scaling(scene).motion_to_hand(start.command), INFINITY,
                        INFINITY);
    Eigen::Index n = 0;
    run_insertion(
        testing::setup(scene, trial), hand, testing::recording_settings(), [&](const Tick& tick) {
          const HandTwist recorded = episode.rows.row(n).segment<5>(kCommand.begin).transpose();
          EXPECT_LE((tick.command - recorded).norm(), 1e-9) << name << " row " << n;
          return ++n + 1 < episode.rows.rows() && !::testing::Test::HasFailure();
        });
    EXPECT_EQ(n + 1, episode.rows.rows());
    std::filesystem::remove(episode_files(folder.path()).front());
  }
}

}  // namespace
}  // namespace ferrule
