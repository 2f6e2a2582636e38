#include "sim/model/state.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

namespace ferrule {
namespace {

TEST(State, IsARowOfNumbersAndBack) {
  State state;
  for (Pose* const pose : {&state.tip, &state.command, &state.velocity, &state.tip_before})
    *pose = Pose::Random();
  state.velocity_before << 1, 2, 3, 4, 5;
  state.time = 6;
  state.dt_before = 7;
  state.air = 8;
  state.side = EdgeSide::face;
  state.bridge = true;
  state.contact = {{{true, 9, {10, 11, 12}, 13}, {false, 14, {15, 16, 17}, 18}}};
  const StateRow row = to_row(state);
  const State back = state_of(row);
  EXPECT_EQ(to_row(back), row);
  EXPECT_EQ(back.tip, state.tip);
  EXPECT_EQ(back.command, state.command);
  EXPECT_EQ(back.velocity, state.velocity);
  EXPECT_EQ(back.tip_before, state.tip_before);
  EXPECT_EQ(back.velocity_before, state.velocity_before);
  EXPECT_EQ(back.time, 6);
  EXPECT_EQ(back.dt_before, 7);
  EXPECT_EQ(back.side, EdgeSide::face);
  EXPECT_TRUE(back.bridge);
  EXPECT_TRUE(back.contact[kEnd].closed && !back.contact[kSide].closed);
  EXPECT_EQ(back.contact[kEnd].branch, 13);
  EXPECT_EQ(back.contact[kSide].stuck, Vector3d(15, 16, 17));
  // Where recorded rows have them.
  EXPECT_EQ(row[10], 6);
  EXPECT_EQ(row[13], 1);
  EXPECT_EQ(row[24], 18);
  EXPECT_EQ(row[35], 1);
  EXPECT_EQ(row[41], 8);
}

TEST(State, HasANameAndAUnitForEveryNumber) {
  const auto words = [](const std::string& text) {
    return 1 + std::count(text.begin(), text.end(), ' ');
  };
  for_each_field([&](const StateField& field, auto numbers_of) {
    State state;
    std::ptrdiff_t numbers = 0;
    const auto count = [&](const auto& part) {
      if constexpr (requires { part.rows(); })
        numbers += part.size();
      else
        ++numbers;
    };
    std::apply([&](const auto&... parts) { (count(parts), ...); }, numbers_of(state));
    EXPECT_EQ(words(field.names), numbers) << field.about;
    EXPECT_EQ(words(field.units), numbers) << field.about;
  });
}

}  // namespace
}  // namespace ferrule
