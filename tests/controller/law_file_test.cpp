#include "controller/law_file.hpp"

#include <fstream>

#include "tests/compare.hpp"
#include "tests/refusal.hpp"
#include "tests/temporary_folder.hpp"

namespace ferrule {
namespace {

LawFile example() {
  LawFile c;
  for (std::size_t i = 0; i < kGains; ++i)
    c.gains[i] = {0.1 + static_cast<double>(i) / 3, 0.01, 10};
  c.gains[4].low = c.gains[4].high = NAN;
  c.trained_on.scenes = {"demo"};
  c.trained_on.episodes = {{"a.h5", "12ab"}, {"b.h5", "34cd"}};
  c.trained_on.held_out = {{"c.h5", "56ef"}};
  c.trained_on.rows = 1234;
  c.reaction_time = 0.17;
  return c;
}

TEST(LawFile, IsReadBackExactly) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "controller.json";
  write_controller(file, example());
  const LawFile back = read_law(file);
  EXPECT_EQ(back.law().gains(), example().law().gains());
  EXPECT_TRUE(std::isnan(back.gains[4].low));
  EXPECT_EQ(back.trained_on.episodes, example().trained_on.episodes);
  EXPECT_EQ(back.trained_on.held_out, example().trained_on.held_out);
  EXPECT_EQ(back.reaction_time, 0.17);
}

TEST(LawFile, KeepsWhichLawItIsAndTheLawsItWasChosenFrom) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "controller.json";
  for (const LawKind kind : kLaws) {
    LawFile c = example();
    c.kind = kind;
    c.gains.assign(gain_table(kind).size(), {0.25, 0.1, NAN});
    c.cross_validation = {{LawKind::linear, 2e-3, 1e-4}, {kind, 1e-3, 2e-4}};
    write_controller(file, c);
    const LawFile back = read_law(file);
    EXPECT_EQ(back.kind, kind);
    EXPECT_EQ(back.law().gains(), c.law().gains());
    ASSERT_EQ(back.cross_validation.size(), kind == LawKind::linear ? 1u : 2u);
    EXPECT_EQ(back.cross_validation.back().kind, kind);
    EXPECT_EQ(back.cross_validation.back().error, 1e-3);
    EXPECT_EQ(back.cross_validation.back().standard_error, 2e-4);
    // The same with tilt gains.
    c.gains.insert(c.gains.end(), {{2e-4, 1e-4, 3e-4}, {0, NAN, NAN}});
    write_controller(file, c);
    EXPECT_EQ(read_law(file).law().gains(), c.law().gains());
    EXPECT_EQ(read_law(file).gains[gain_table(kind).size()].high, 3e-4);
  }
}

TEST(LawFile, BrokenOnesAreRefusedWithTheirKey) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "controller.json";
  write_controller(file, example());
  const Json good = parse_json(read_text(file), file);
  const auto says = [&](const char* pointer, const Json& value, const char* reason) {
    const std::string said = testing::refusal(file, good, pointer, value, read_law);
    EXPECT_NE(said.find(reason), std::string::npos) << pointer << ": " << said;
  };
  says("/gains/ramp_time/value", 0, "gains.ramp_time.value = 0: must be positive");
  says("/gains/yield_y/unit", "N", "gains.yield_y.unit");
  says("/trained_on/episodes/1", "b.h5", "trained_on.episodes[1] = \"b.h5\": must be an object");
  says("/format_version", 1, "format_version = 1");
  says("/surprise", 1, "surprise = 1: unknown key");
  says("/gains/cruise_speed/value", "fast", "must be a number");
  const Json tilt = {{"value", 1}, {"unit", "rad/(s N m)"}};
  says("/gains/tilt_yield_z", tilt, "gains.tilt_yield_y is missing");
}

TEST(LawFile, CannotBeWrittenWhereThereIsNoFolder) {
  EXPECT_THROW(write_controller("/no/such/folder/controller.json", example()), FileTrouble);
}

}  // namespace
}  // namespace ferrule
