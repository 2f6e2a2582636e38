#include "insertion/hand_device.hpp"

#include <fstream>

#include "capture/replay.hpp"
#include "haptic/hid/drivers.hpp"
#include "haptic/hid/fake_firmware.hpp"
#include "sim/scene/draw.hpp"
#include "tests/compare.hpp"
#include "tests/episodes.hpp"
#include "tests/scenes.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

constexpr FakeModel kModels[] = {FakeModel::space_mouse_split, FakeModel::space_mouse_combined,
                                 FakeModel::pid_18, FakeModel::pid_22};

constexpr double kFull = 8;  // [N]

const Driver& driver_of(FakeModel model) {
  return *ferrule::driver_of(FakeFirmware::describe(model));
}

std::unique_ptr<Device> hand_on(FakeModel model, const Scene& scene, double gain) {
  return fake_hand(driver_of(model), std::make_unique<FakeFirmware>(model), scene,
                   draw_start(scene, 1, 1), gain, kFull);
}

EpisodeInfo info_of(const Scene& scene, const Device& device) {
  EpisodeInfo info = testing::info_of(scene, 1, 1);
  info.mapping = mapping_text(*device.mapping());
  return info;
}

// Records until the device is done or lost; returns the outcome.
Outcome run(const Scene& scene, Device& device, Recorder& recorder) {
  return run_insertion(testing::felt_exactly(scene), device, testing::recording_settings(),
                       [&](const Tick& tick) {
                         recorder.add(make_row(tick), tick.sample.counts);
                         return true;
                       })
      .outcome;
}

// An episode of the fake hand in a folder of its own.
struct Recording {
  testing::TemporaryFolder folder;
  std::string file, mapping;
  Episode episode;

  Recording(const Scene& scene, FakeModel model, double gain) {
    const auto device = hand_on(model, scene, gain);
    const EpisodeInfo info = info_of(scene, *device);
    mapping = info.mapping;
    Recorder recorder(folder.path(), 1, info);
    file = recorder.finish(run(scene, *device, recorder));
    episode = read_episode(file);
  }
};

TEST(HandDevice, TheFakeHandInsertsWithEveryModelAndTheEpisodeReplays) {
  const Scene scene = testing::quick();
  for (const FakeModel model : kModels) {
    const Recording r(scene, model, 1);
    EXPECT_EQ(r.episode.info.outcome, Outcome::inserted);
    EXPECT_FALSE(verify(r.episode).has_value());
    EXPECT_FALSE(file_difference(r.file).has_value());
    EXPECT_EQ(r.episode.info.mapping, r.mapping);
  }
}

// A reader of the file finds the hand's motion again from counts and mapping alone.
TEST(HandDevice, CountsAndMappingInTheFileAreTheMotion) {
  const Scene scene = testing::quick();
  for (const FakeModel model : kModels) {
    const Recording recording(scene, model, 1.5);
    const Episode& episode = recording.episode;
    const Json mapping = Json::parse(episode.info.mapping);
    const bool velocity = mapping["motion"] == "velocity";
    ASSERT_EQ(velocity, driver_of(model).force == nullptr);
    const auto limit = mapping["limit_counts"].get<std::array<double, kRawAxes>>();
    const auto centre = mapping["centre_counts"].get<std::array<double, kRawAxes>>();
    const double dead = mapping["dead_zone"];
    std::vector<std::array<double, kRawAxes>> gain = mapping[velocity ? "gain_m_s" : "gain_m"];
    for (const Json& row : mapping[velocity ? "gain_rad_s" : "gain_rad"]) gain.push_back(row);
    ASSERT_EQ(gain.size(), 5u);
    const auto deflection = [&](Eigen::Index row, std::size_t axis) {
      if (limit[axis] == 0) return 0.0;
      const double d =
          (episode.counts(row, static_cast<Eigen::Index>(axis)) - centre[axis]) / limit[axis];
      const double size = std::min(1.0, std::max(0.0, (std::abs(d) - dead) / (1 - dead)));
      return d < 0 ? -size : size;
    };
    ASSERT_EQ(episode.counts.rows(), episode.rows.rows());
    EXPECT_GT((episode.counts.cwiseAbs().maxCoeff()), 100);
    double worst = 0, largest = 0;
    for (Eigen::Index n = 0; n + 1 < episode.rows.rows(); ++n)
      for (int k = 0; k < 5; ++k) {
        double expected = 0;
        for (std::size_t axis = 0; axis < kRawAxes; ++axis)
          expected +=
              gain[static_cast<std::size_t>(k)][axis] *
              (velocity ? deflection(n, axis) : deflection(n + 1, axis) - deflection(0, axis));
        const double pose = episode.rows(n + 1, kHandPose.begin + k);
        const double moved = velocity ? episode.rows(n, kCommand.begin + k)
                                      : pose - episode.rows(0, kHandPose.begin + k);
        worst = std::max(worst, std::abs(moved - expected));
        largest = std::max(largest, std::abs(moved));
      }
    EXPECT_GT(largest, 1e-3);
    EXPECT_LT(worst, 1e-9 * largest);
  }
}

// Unplugged in the middle: the rows until then are there, the outcome says interrupted.
TEST(HandDevice, AnEpisodeWhoseDeviceIsLostKeepsItsRows) {
  const Scene scene = testing::quick();
  const State start = draw_start(scene, 1, 1);
  for (const FakeModel model : kModels) {
    const testing::TemporaryFolder folder;
    FakeFirmware firmware(model);
    const auto driver = driver_of(model).make(firmware, driver_settings(scene, start, 1, kFull));
    class Unplugged : public Device {
     public:
      Unplugged(FakeFirmware& f, Device& d) : firmware_(f), device_(d) {}
      HandSample read(double t) override {
        if (++reads_ > 333) firmware_.unplug();
        firmware_.deflect({-60, 0, 0, 0, 0, 0});
        firmware_.advance(t);
        return device_.read(t);
      }
      void render(const HandWrench& wrench) override { device_.render(wrench); }

     private:
      FakeFirmware& firmware_;
      Device& device_;
      int reads_ = 0;
    } device(firmware, *driver);
    Recorder recorder(folder.path(), 1, info_of(scene, *driver));
    const Outcome outcome = run(scene, device, recorder);
    EXPECT_EQ(outcome, Outcome::interrupted);
    const Episode episode = read_episode(recorder.finish(outcome));
    EXPECT_EQ(episode.rows.rows(), 333);
    EXPECT_EQ(episode.info.outcome, Outcome::interrupted);
    EXPECT_EQ(episode.counts(300, 0), -60);
    EXPECT_FALSE(verify(episode).has_value());
  }
}

TEST(HandDevice, AKilledRecordingIsRecoveredWithItsCounts) {
  const testing::TemporaryFolder folder;
  const Scene scene = testing::quick();
  const State start = draw_start(scene, 1, 1);
  CountRows counts(300, kRawAxes);
  {
    const auto device = hand_on(FakeModel::space_mouse_split, scene, 1);
    Recorder recorder(folder.path(), 1, info_of(scene, *device));
    Eigen::Index n = 0;
    run_insertion(testing::setup(scene, start), *device, testing::recording_settings(),
                  [&](const Tick& tick) {
                    recorder.add(make_row(tick), tick.sample.counts);
                    if (n < 300) counts.row(n) = tick.sample.counts.transpose();
                    return ++n != 350;
                  });
  }  // left without finish
  const auto recovered = recover(folder.path());
  ASSERT_EQ(recovered.size(), 1u);
  EXPECT_EQ(recovered[0].rows, 300u);
  const Episode episode = read_episode(recovered[0].file);
  EXPECT_EQ(episode.counts, counts);
  EXPECT_FALSE(episode.info.mapping.empty());
  EXPECT_FALSE(verify(episode).has_value());
}

// A recording without a device is what it was: no mapping, no counts.
TEST(HandDevice, SimulatedOperatorsHaveNoCounts) {
  const testing::TemporaryFolder folder;
  const Episode episode = read_episode(testing::record(testing::quick(), folder.path(), 1));
  EXPECT_TRUE(episode.info.mapping.empty());
  EXPECT_EQ(episode.counts.rows(), 0);
}

TEST(HandDevice, AForceStickFeelsTheFibreAndIsLetGoAtTheEnd) {
  const Scene scene = testing::quick();
  const State start = draw_start(scene, 1, 1);
  FakeFirmware firmware(FakeModel::pid_22);
  {
    const auto stick =
        driver_of(FakeModel::pid_22).make(firmware, driver_settings(scene, start, 1, kFull));
    for (int n = 0; n < 50; ++n) {
      firmware.advance(1e-3 * n);
      stick->read(1e-3 * n);
      HandWrench wrench = HandWrench::Zero();
      wrench[1] = -0.1 * kFull;
      stick->render(wrench);
    }
    // Down is along the stick's +Y.
    EXPECT_CLOSE(firmware.force()[1], 0.1, 1e-4);
    EXPECT_LT(std::abs(firmware.force()[0]), 1e-12);
  }
  EXPECT_EQ(firmware.force()[1], 0);
  EXPECT_FALSE(firmware.actuators());
}

}  // namespace
}  // namespace ferrule
