#include "view/frame.hpp"

#include <gtest/gtest.h>

#include "insertion/loop.hpp"
#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"
#include "tests/episodes.hpp"

namespace ferrule {
namespace {

// The frames of an insertion by a simulated operator, with the rows that they are of.
struct Shown {
  std::vector<RowVector> rows;
  std::vector<Frame> frames;
  InsertionEnd end;
};

std::size_t column(const std::string& name) {
  const auto names = frame_columns();
  const auto found = std::find(names.begin(), names.end(), name);
  EXPECT_NE(found, names.end()) << name;
  return static_cast<std::size_t>(found - names.begin());
}

Shown shown(const Scene& scene, std::uint64_t trial) {
  const auto hand = simulated_operator(testing::setup(scene, trial), 0.8);
  FrameMaker make(scene, ForceSensor(scene.sensor, 1, trial), 1e-3);
  Shown all;
  all.end = run_insertion(testing::setup(scene, trial), *hand, {}, [&](const Tick& tick) {
    all.rows.push_back(make_row(tick));
    all.frames.push_back(make(all.rows.back()));
    // What is felt is what the loop's sensor read.
    const auto& felt = all.frames.back();
    static const std::size_t force = column("force_x_uN");
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_EQ(felt[force + i], static_cast<float>(1e6 * (tick.relative[static_cast<int>(i)] /
                                                           scene_scaling(scene).force)));
    return true;
  });
  return all;
}

TEST(Frame, HasANameOfItsOwnForEveryColumn) {
  auto names = frame_columns();
  EXPECT_EQ(names.size(), kFrameColumns);
  std::sort(names.begin(), names.end());
  EXPECT_EQ(std::adjacent_find(names.begin(), names.end()), names.end());
}

TEST(Frame, ShowsAnInsertionFromApproachToSeated) {
  const Scene scene = load_scene("demo");
  const Shown all = shown(scene, 1);
  ASSERT_EQ(all.end.outcome, Outcome::inserted);
  const std::size_t phase = column("phase");
  EXPECT_EQ(all.frames.front()[phase], static_cast<float>(Phase::approach));
  EXPECT_EQ(all.frames.back()[phase], static_cast<float>(Phase::seated));
  const auto& last = all.frames.back();
  EXPECT_FLOAT_EQ(last[column("depth_um")], static_cast<float>(1e6 * all.end.summary.depth));
  EXPECT_FLOAT_EQ(last[column("loss_offset_um")], static_cast<float>(1e6 * all.end.summary.offset));
  EXPECT_FLOAT_EQ(last[column("limit_uN")], 10);
  float peak = 0;
  for (const Frame& frame : all.frames) peak = std::max(peak, frame[column("force_uN")]);
  EXPECT_FLOAT_EQ(peak, static_cast<float>(1e6 * all.end.summary.peak_force));
}

TEST(Frame, TermsBalanceTheHolder) {
  const Scene scene = load_scene("bench");
  const Shown all = shown(scene, 2);
  const std::size_t first_term = column("van_der_waals_x_uN");
  const RowVector& rest = all.rows.front();
  const Frame& frame_at_rest = all.frames.front();
  for (std::size_t n = 0; n < all.rows.size(); n += 97) {
    // At the quasi-static rest all forces along x but the holder's add up to that on the holder.
    double sum = 0;
    for (std::size_t t = 0; t < kTerms; ++t)
      sum += all.frames[n][first_term + 3 * t] - frame_at_rest[first_term + 3 * t];
    const double held = 1e6 * (all.rows[n][kHolder.begin] - rest[kHolder.begin]);
    EXPECT_NEAR(sum, held, 1e-2 + 1e-3 * std::abs(held)) << n;
  }
}

TEST(Frame, ContactIsOnTheFibresSurfaceAndCarriesTheNormalForce) {
  const Scene scene = load_scene("bench");
  const Shown all = shown(scene, 2);
  const std::size_t on = column("contact0_on"), y = column("contact0_y_um"),
                    tip = column("tip_y_um"), wall = column("wall_x_uN"),
                    adhesion = column("adhesion_x_uN"), other = column("contact1_on");
  int seen = 0;
  for (const Frame& frame : all.frames) {
    if (frame[on] == 0 || frame[other] != 0) continue;
    ++seen;
    EXPECT_NEAR(std::hypot(frame[y] - frame[tip], frame[y + 1] - frame[tip + 1]),
                1e6 * scene.world.annulus.fibre_radius, 0.2);
    Vector3d force;
    for (std::size_t i = 0; i < 3; ++i)
      force[static_cast<int>(i)] = frame[wall + i] + frame[adhesion + i];
    // On the rounded edge the normal is a mean of those of bore and cone, 30 degrees apart.
    EXPECT_NEAR(std::abs(frame[y + 2]), force.norm(), 1e-3 + 0.035 * std::abs(frame[y + 2]));
  }
  EXPECT_GT(seen, 100);
}

// The hand that goes the way that is shown has the fibre in the middle, and is shown none.
TEST(Frame, ShowsWhichWayToCorrect) {
  const Scene scene = load_scene("hard");
  const std::size_t way = column("way_y_um"), tip = column("tip_y_um"),
                    holder = column("holder_y_um");
  for (const double depth : {-50e-6, 40e-6}) {
    const auto frame_of = [&](const Vector2d& offset) {
      Pose pose;
      pose << -depth, offset, 2e-3, -1e-3;
      State state = at_rest(scene.world, pose);
      RowVector row = RowVector::Zero();
      row.segment<kStateSize>(kStates.begin) = to_row(state).transpose();
      return FrameMaker(scene, ForceSensor(), 1e-3)(row);
    };
    const Vector2d off(3e-6, -8e-6);
    const Frame aside = frame_of(off);
    const Vector2d shown(aside[way], aside[way + 1]);
    const Vector2d middle = off + 0.5 * std::max(0.0, depth) * Vector2d(2e-3, -1e-3);
    EXPECT_LT((shown + 1e6 * middle).norm(), 1e-3) << depth;
    const Frame there = frame_of(off + 1e-6 * shown);
    EXPECT_LT(std::hypot(there[way], there[way + 1]), 1e-4);
    // The fibre hangs: it is not the holder that is to be on the axis.
    EXPECT_GT(there[holder], there[tip]);
  }
}

TEST(Frame, AStateSurvivesItsRow) {
  const Scene scene = load_scene("film");
  const Shown all = shown(scene, 3);
  for (std::size_t n = 0; n < all.rows.size(); n += 53) {
    const StateRow row = all.rows[n].segment<kStateSize>(kStates.begin).transpose();
    EXPECT_EQ(to_row(state_of(row)), row);
  }
}

TEST(Frame, SceneTellsItsGeometry) {
  const Json json = scene_json(load_scene("demo"));
  EXPECT_DOUBLE_EQ(json["geometry"]["fibre_radius_um"], 62.5);
  EXPECT_DOUBLE_EQ(json["geometry"]["mouth_radius_um"], 125);
  EXPECT_DOUBLE_EQ(json["success_depth_um"], 60);
  EXPECT_EQ(json["cue"], false);
  EXPECT_EQ(scene_json(load_scene("demo", {"cue=true"}))["cue"], true);
}

}  // namespace
}  // namespace ferrule
