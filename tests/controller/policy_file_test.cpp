#include "controller/policy_file.hpp"

#include "controller/controller_file.hpp"
#include "sim/base/content_hash.hpp"
#include "tests/compare.hpp"
#include "tests/policies.hpp"
#include "tests/refusal.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

// The file that a controller names.
std::string weights_of(const std::string& file) {
  const Json json = parse_json(read_text(file), file);
  return std::filesystem::path(file).parent_path() / json["weights"].get<std::string>();
}

TEST(ContentHash, IsThatOfFips180) {
  EXPECT_EQ(sha1(""), "da39a3ee5e6b4b0d3255bfef95601890afd80709");
  EXPECT_EQ(sha1("abc"), "a9993e364706816aba3e25717850c26c9cd0d89d");
  EXPECT_EQ(sha1(std::string(1000000, 'a')), "34aa973cd4c4daa4f61eeb2bdbad27316534016f");
}

TEST(PolicyFile, IsReadBackExactly) {
  const testing::TemporaryFolder folder;
  const PolicyFile file = testing::random_policy_file();
  write_controller(folder / "c.json", file);
  const PolicyFile back = read_policy(folder / "c.json");
  ASSERT_EQ(back.policy.members.size(), 2u);
  for (std::size_t m = 0; m < 2; ++m)
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(back.policy.members[m][i].weight, file.policy.members[m][i].weight);
      EXPECT_EQ(back.policy.members[m][i].bias, file.policy.members[m][i].bias);
    }
  EXPECT_EQ(back.policy.mean, file.policy.mean);
  EXPECT_EQ(back.policy.velocity_scale, file.policy.velocity_scale);
  EXPECT_EQ(back.policy.spacing, 4);
  EXPECT_EQ(back.trained_on.held_out[0].sha1, file.trained_on.held_out[0].sha1);
  EXPECT_EQ(back.members[1].best_epoch, 25);
  EXPECT_EQ(back.members[0].rollouts, 0u);
  EXPECT_EQ(back.members[1].rollouts, 200u);
  EXPECT_EQ(back.members[1].inserted, 199u);
  EXPECT_EQ(back.dagger[0].held_out_loss, -1.125);
  write_controller(folder / "d.json", back);
  EXPECT_EQ(read_text(weights_of(folder / "c.json")), read_text(weights_of(folder / "d.json")));
}

TEST(PolicyFile, OfOneThatRemembersIsReadBackExactly) {
  const testing::TemporaryFolder folder;
  PolicyFile file = testing::random_policy_file();
  file.policy = testing::random_policy(2, {7, 5}, 1, 20, 1, 9, true);
  write_controller(folder / "c.json", file);
  const PolicyFile back = read_policy(folder / "c.json");
  EXPECT_EQ(back.parameters(), file.parameters());
  EXPECT_EQ(back.policy.mean, file.policy.mean);
  EXPECT_EQ(back.policy.velocity_scale, file.policy.velocity_scale);
  PolicyController before(file.policy), after(back.policy);
  RandomStream random(6, 0, Draw::plan);
  for (int n = 0; n < 50; ++n) {
    const Observation o = testing::random_observation(random);
    EXPECT_EQ(after.command(o), before.command(o));
  }
  const Json good = parse_json(read_text(folder / "c.json"), "c.json");
  const auto says = [&](const char* pointer, const Json& value, const char* reason) {
    const std::string said = testing::refusal(folder / "c.json", good, pointer, value, read_policy);
    EXPECT_NE(said.find(reason), std::string::npos) << pointer << ": " << said;
  };
  says("/memory", 8, "members.0.memory.input_weight.shape: must be [24,11]");
  says("/memory", 0, "memory");
  says("/history/samples", 2, "samples");
  says("/inputs/5/name", "depth", "displacement_x");
  says("/outputs/4/name", "velocity_z", "tilt_rate_z");
}

TEST(PolicyFile, IsLoadedLikeAnyController) {
  const testing::TemporaryFolder folder;
  const PolicyFile file = testing::random_policy_file();
  write_controller(folder / "c.json", file);
  write_controller(folder / "law.json", [] {
    LawFile law;
    law.gains[1].value = law.gains[3].value = 1;
    law.gains[5].value = 2e-3;
    return law;
  }());
  Observation observation{HandWrench::Ones(), 0.5, 0};
  PolicyController direct(file.policy);
  EXPECT_EQ(load_controller(folder / "c.json")(3)->command(observation),
            direct.command(observation));
  EXPECT_CLOSE(load_controller(folder / "law.json")(3)->command(observation)[0], 2e-3, 1e-12);
  write_text(folder / "none.json", R"({"method": "hope"})");
  EXPECT_THROW(load_controller(folder / "none.json"), BadInput);
}

TEST(PolicyFile, BrokenOnesAreRefusedWithTheirKey) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "c.json";
  write_controller(file, testing::random_policy_file());
  const Json good = parse_json(read_text(file), file);
  const auto says = [&](const char* pointer, const Json& value, const char* reason) {
    const std::string said = testing::refusal(file, good, pointer, value, read_policy);
    EXPECT_NE(said.find(reason), std::string::npos) << pointer << ": " << said;
  };
  says("/ensemble", 3, "members.2.layers.0.weight is missing");
  says("/ensemble", 1, "no such array in the controller");
  says("/ensemble", 1000000000, "ensemble");
  says("/hidden", {7, 6}, "shape: must be [6,7]");
  says("/hidden", {7, 1e9}, "hidden");
  says("/hidden", Json::array(), "hidden");
  says("/history/samples", 4, "shape: must be [7,21]");
  says("/history/spacing_periods", 0, "history.spacing_periods");
  says("/inputs/2/scale", 0, "inputs[2].scale = 0: must be positive");
  says("/inputs/5/unit", "mm", "inputs[5].unit");
  says("/outputs/0/scale", -1, "outputs[0].scale = -1: must not be negative");
  says("/limits/speed_m_s", nullptr, "limits.speed_m_s");
  says("/weights", "../c.safetensors", "in the same folder");
  says("/weights", "/etc/passwd", "in the same folder");
  says("/weights", "none.safetensors", "trouble: ");
  says("/weights", ".", "in the same folder");
  says("/weights_sha1", "0", "weights_sha1");
  says("/world", "tip", "world");
  says("/period_s", 0.002, "period_s = 0.002: must be 0.001");
  says("/trained_on/episodes/0/surprise", 1, "unknown key");
  says("/surprise", 1, "surprise = 1: unknown key");
}

TEST(PolicyFile, IsWrittenWholeOrNotAtAll) {
  const testing::TemporaryFolder folder;
  std::filesystem::create_directory(folder / "c.json");
  EXPECT_THROW(write_controller(folder / "c.json", testing::random_policy_file()), FileTrouble);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

// A run that is killed after its weights have got their name leaves the controller of before.
TEST(PolicyFile, WeightsOfAnotherFitDoNotTouchTheControllerThatIsThere) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "c.json";
  PolicyFile policy = testing::random_policy_file();
  write_controller(file, policy);
  const std::string weights = weights_of(file);
  policy.policy.members[0][0].bias[0] += 1;
  write_controller(file, policy);
  EXPECT_NE(weights_of(file), weights);
  EXPECT_FALSE(std::filesystem::exists(weights));  // nobody names them any more
  // As it is between the two renames of a third fit.
  const std::string third = weights_file(file, sha1("third"));
  write_text(third, "of a run that was killed");
  EXPECT_EQ(read_policy(file).policy.members[0][0].bias, policy.policy.members[0][0].bias);
  write_controller(file, policy);
  EXPECT_FALSE(std::filesystem::exists(third));
}

TEST(PolicyFile, HalfWrittenWeightsOfAKilledFitAreRemovedByTheNext) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "c.json", half = ".Ab3dEf.tmp";
  const std::string ours = weights_file(file, sha1("killed")) + half;
  const std::string others = weights_file(folder / "d.json", sha1("killed")) + half;
  const std::string no_weights = (folder / "c.safetensors") + half;
  for (const std::string& name : {ours, others, no_weights}) write_text(name, "half");
  write_controller(file, testing::random_policy_file());
  EXPECT_FALSE(std::filesystem::exists(ours));
  EXPECT_TRUE(std::filesystem::exists(others));
  EXPECT_TRUE(std::filesystem::exists(no_weights));
}

TEST(PolicyFile, KeepsWeightsThatACopyOfTheControllerNames) {
  const testing::TemporaryFolder folder;
  PolicyFile policy = testing::random_policy_file();
  write_controller(folder / "c.json", policy);
  std::filesystem::copy_file(folder / "c.json", folder / "copy.json");
  policy.policy.members[0][0].bias[0] += 1;
  write_controller(folder / "c.json", policy);
  EXPECT_NO_THROW(read_policy(folder / "copy.json"));
}

TEST(PolicyFile, RefusesWeightsThatAreNotItsOwn) {
  const testing::TemporaryFolder folder;
  PolicyFile file = testing::random_policy_file();
  write_controller(folder / "a.json", file);
  file.policy.members[0][0].bias[0] += 1;
  write_controller(folder / "b.json", file);
  std::filesystem::copy_file(weights_of(folder / "b.json"), weights_of(folder / "a.json"),
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_THROW(read_policy(folder / "a.json"), BadInput);
}

}  // namespace
}  // namespace ferrule
