#include "sim/analysis/plan.hpp"

#include <algorithm>
#include <numbers>

#include "sim/analysis/sampled_run.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr std::uint64_t kScenes = 100;

// A scene with terms drawn from none to strong, any form, either holder.
Scene random_scene(std::uint64_t k) {
  RandomStream random(77, k, Draw::start);
  const auto between = [&](double low, double high) {
    return low + (high - low) * random.uniform();
  };
  const auto decades = [&](double low, double high) {
    return low * std::pow(high / low, random.uniform());
  };
  const auto chance = [&](double p) { return random.uniform() < p; };
  const auto form = [&] { return chance(0.5) ? "printed" : "corrected"; };
  Json d = testing::paper().document();
  d["name"] = "random";
  d["ferrule"]["bore_diameter_um"] = 125 + between(0.6, 2.5);
  if (chance(0.3)) d["ferrule"]["lead_in"] = nullptr;
  d["roughness_nm"] = decades(1, 50);
  Json laws = Json::object();
  // Present or not; as strong as they are in nature, or weaker down to nothing.
  const auto strength = [&](double natural) {
    return natural * (chance(0.5) ? between(0.3, 1) : decades(1e-14, 1e-2));
  };
  if (chance(0.7)) laws["van_der_waals"] = {{"form", form()}, {"hamaker_J", strength(3e-19)}};
  if (chance(0.7))
    laws["electrostatic"] = {{"form", form()}, {"voltage_V", std::sqrt(strength(0.01))}};
  if (chance(0.7)) laws["gravity"] = {{"form", form()}};
  if (chance(0.3))
    laws["capillary"] = {{"form", form()},
                         {"surface_tension_N_m", strength(0.07)},
                         {"contact_angle_deg", between(10, 80)},
                         {"film_nm", between(20, 90)},
                         {"volume_per_length_m2", decades(1e-14, 1e-12)},
                         {"rupture_nm", between(200, 400)}};
  if (chance(0.4))
    laws["adhesion"] = {{"form", form()},
                        {"work_of_adhesion_J_m2", decades(1e-3, 0.2)},
                        {"maugis_lambda", decades(0.2, 5)},
                        {"m", 1.05}};
  if (chance(0.4)) laws["friction"] = {{"form", form()}, {"burgers_nm", decades(0.05, 1)}};
  if (chance(0.15)) laws["drag"] = {{"form", "corrected"}, {"viscosity_Pa_s", strength(1)}};
  if (chance(0.3))
    laws["meniscus"] = {{"form", "corrected"},
                        {"surface_tension_N_m", strength(0.05)},
                        {"contact_angle_deg", between(10, 80)}};
  d["laws"] = laws;
  if (chance(0.3))
    d["holder"] = {{"type", "elastic_fibre"},
                   {"free_length_mm", between(3, 8)},
                   {"gripper_stiffness_N_m", 1000}};
  d["dynamics"] = "quasi_static";
  d["start"] = {{"distance_um", between(1, 4)},
                {"lateral_mean_um", {0, 0}},
                {"lateral_sd_um", decades(0.05, 3)},
                {"tilt_sd_mrad", decades(0.1, 3)}};
  d["limits"] = {{"force_uN", decades(5, 50)}, {"speed_um_s", decades(30, 90)}, {"time_s", 60}};
  d["success"] = {{"depth_um", between(2, 6)}};
  return parse_scene(d, "random scene");
}

// A motion unlike the planner's probes: in and out again on a sine, while wandering sideways and in
// tilt on incommensurable ones, no faster than the limit.
std::vector<Pose> motion(const Scene& scene, const State& start, std::uint64_t k) {
  RandomStream random(99, k, Draw::operator_hand);
  const auto around = [&](double a) { return a * (2 * random.uniform() - 1); };
  const World& world = scene.world;
  const double c = world.annulus.clearance(), depth = scene.success.depth;
  const double way = start.tip[0] + depth;
  const double duration = std::numbers::pi / 2 * way / (0.5 * scene.limits.speed);
  const double aside =
      std::min(2 * c, 0.2 * scene.limits.speed * duration / (2 * std::numbers::pi));
  const double lean = std::min({c / depth, scene.start.tilt_sd, 0.02});
  const double a = around(aside), b = around(aside), p = around(1), q = around(1);
  const double s = around(lean), t = around(lean);
  std::vector<Pose> hand;
  const auto count = static_cast<std::size_t>(2 * duration / 1e-3);
  for (std::size_t n = 0; n < count; ++n) {
    const double phase = static_cast<double>(n) / static_cast<double>(count);
    const double in = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * phase);
    // It comes to the middle on the way in.
    const double centred = std::min(1.0, 4 * phase);
    const double near = 1 - centred * centred * (3 - 2 * centred);
    Pose tip = start.tip;
    tip[0] -= way * in;
    tip[1] = near * start.tip[1] + (1 - near) * a * std::sin(7.3 * phase + 3 * p);
    tip[2] = near * start.tip[2] + (1 - near) * b * std::sin(5.1 * phase + 3 * q);
    tip[3] = near * start.tip[3] + (1 - near) * s * std::sin(6.7 * phase);
    tip[4] = near * start.tip[4] + (1 - near) * t * std::sin(4.9 * phase);
    hand.push_back(tip - world.holder.sag);
  }
  hand.front() = start.command;
  return hand;
}

// The full model: every term, the finest fidelity, the planned step.
World full_model(const Scene& scene, double step) {
  Json d = scene.document();
  d["quadrature"] = 16;
  d["step_s"] = step;
  return parse_scene(d, "full").world;
}

TEST(Plan, LeavesOutWhatDoesNotActAndSaysWhatItWouldHaveChanged) {
  // A fibre in free flight and against a wall, without friction; a voltage of a nanovolt.
  const Scene scene =
      testing::paper({"laws={}", "laws.electrostatic={\"form\":\"corrected\",\"voltage_V\":1e-9}",
                      "laws.gravity={\"form\":\"corrected\"}", "roughness_nm=5"});
  const Plan plan = make_plan(scene, 0.01);
  ASSERT_EQ(plan.terms.size(), 4u);  // electrostatic, gravity, wall, inertia
  EXPECT_EQ(plan.terms[0].name, "electrostatic");
  EXPECT_FALSE(plan.terms[0].kept);
  EXPECT_LT(plan.terms[0].relative_error, 1e-6);
  EXPECT_TRUE(plan.terms[1].kept);
  EXPECT_CLOSE(plan.terms[1].max_force, weight(scene.world.laws.gravity, scene.world.fibre), 1e-12);
  const World planned = parse_scene(plan.document, "planned").world;
  EXPECT_FALSE(present(planned.laws.electrostatic));
  EXPECT_EQ(planned.numerics.extrapolation_tip, scene.world.numerics.extrapolation_tip);
  EXPECT_LE(plan.error_bound, 0.01);
}

TEST(Plan, LeavesOutAParticleThatIsLowWhereverItIs) {
  const auto planned = [](const std::string& height_um) {
    const Plan plan =
        make_plan(load_scene("bench", {"laws.particle={\"form\":\"corrected\",\"at_um\":60,"
                                       "\"direction_deg\":10,\"height_um\":" +
                                       height_um + "}"}),
                  0.05);
    const auto found = std::find_if(plan.terms.begin(), plan.terms.end(),
                                    [](const PlannedTerm& t) { return t.name == "particle"; });
    const Scene scene = parse_scene(plan.document, "planned");
    EXPECT_EQ(scene.world.laws.particle.has_value(), found->kept);
    return *found;
  };
  EXPECT_TRUE(planned("0.3").kept);
  EXPECT_TRUE(planned("0.001").kept);
  const PlannedTerm low = planned("0.000001");
  EXPECT_FALSE(low.kept);
  EXPECT_GE(low.relative_error, 0.99e-12 / 0.5e-6);
}

TEST(PlanAtLength, ChoosesInertiaWhereItMatters) {
  // A soft and fast hand: m a/(k c) is far above the tolerance.
  const Scene fast = testing::bare({"holder.stiffness_N_m=0.05", "limits.speed_um_s=1000"});
  EXPECT_EQ(make_plan(fast, 0.01).dynamics, Dynamics::inertial);
  const Scene slow = testing::bare({"holder.stiffness_N_m=5", "limits.speed_um_s=10"});
  EXPECT_EQ(make_plan(slow, 0.01).dynamics, Dynamics::quasi_static);
}

// A snap that rings as the hand moves on is not left out; one that is over before it has is.
TEST(PlanAtLength, JudgesInertiaByHowLongASnapRings) {
  const auto planned = [](double loss_factor, double speed) {
    const Scene scene = testing::bare(
        {"holder={\"type\":\"elastic_fibre\",\"free_length_mm\":10,\"gripper_stiffness_N_m\":100,"
         "\"loss_factor\":" +
             std::to_string(loss_factor) + "}",
         "limits.speed_um_s=" + std::to_string(speed)});
    return std::pair(make_plan(scene, 0.1), scene.world.holder.bending_frequency());
  };
  const auto [quick, omega] = planned(0.1, 20);
  EXPECT_CLOSE(quick.rings, 2 * std::log(10) / (0.1 * omega), 1e-12);
  EXPECT_EQ(quick.dynamics, Dynamics::inertial);  // 0.3 clearances
  const Plan slow = planned(0.1, 3).first;
  EXPECT_EQ(slow.dynamics, Dynamics::quasi_static);
  EXPECT_CLOSE(slow.terms.back().relative_error, 3e-6 * slow.rings / 0.5e-6, 1e-9);
  EXPECT_LE(slow.terms.back().relative_error, slow.error_bound);
  EXPECT_EQ(planned(0.002, 3).first.dynamics, Dynamics::inertial);
  const Plan undamped = planned(0, 20).first;
  EXPECT_EQ(undamped.rings, INFINITY);
  EXPECT_EQ(undamped.dynamics, Dynamics::quasi_static);
}

TEST(Plan, OfASceneThatIsPlannedAlreadyIsAppliedOnce) {
  Json document = testing::paper().document();
  document["accuracy"] = 0.02;
  const Scene scene = planned(parse_scene(document, "paper"));
  EXPECT_EQ(scene.document().at("planned_accuracy"), 0.02);
  EXPECT_FALSE(scene.document().contains("accuracy"));
  EXPECT_EQ(parse_scene(scene.document(), "again").document(), scene.document());
}

TEST(Plan, RefusesATolerance) {
  const Scene scene = testing::bare();
  for (const double tolerance : {0.0, 1e-7, 0.6, -1.0, std::nan("")})
    EXPECT_THROW(make_plan(scene, tolerance), BadInput) << tolerance;
}

TEST(RunError, IsZeroOfEqualRunsAndCountsAnEventByTheHandsTravel) {
  const World world = testing::bare().world;  // clearance 0.5 um, 0.5 N/m
  std::vector<Pose> hand(100, Pose::Zero());
  SampledRun full;
  for (std::size_t n = 0; n < hand.size(); ++n) {
    hand[n][0] = -1e-9 * static_cast<double>(n);
    full.tip.push_back({hand[n][0], n < 50 ? 0.0 : 400e-9, 0});  // it snaps
    full.force.push_back({1e-6, 0, 0});
  }
  EXPECT_EQ(run_error(full, full, hand, world), 0);
  SampledRun later = full;
  for (std::size_t n = 50; n < 60; ++n) later.tip[n][1] = 0;
  // Ten samples late: nine beyond the one it is resolved to, a nanometre each, and tip x besides.
  EXPECT_NEAR(run_error(later, full, hand, world), 10.0 / 500, 1.1 / 500);
  SampledRun off = full;
  off.force[3][1] = 0.05e-6;
  EXPECT_CLOSE(run_error(off, full, hand, world), 0.05, 1e-9);
  SampledRun never = full;
  for (Vector3d& tip : never.tip) tip[1] = 0;
  EXPECT_GT(run_error(never, full, hand, world), 0.09);
}

// A quarter of the scenes each, so that they run side by side.
class PlanOfRandomScenesAtLength : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(PlanOfRandomScenesAtLength, IsRightForMotionsItHasNotSeen) {
  std::size_t left_out = 0;
  for (std::uint64_t k = GetParam(); k < kScenes; k += 4) {
    const Scene scene = random_scene(k);
    RandomStream random(55, k, Draw::split);
    const double tolerance = 1e-3 * std::pow(100.0, random.uniform());
    const Plan plan = make_plan(scene, tolerance);
    const World planned = parse_scene(plan.document, "planned").world;
    const World full = full_model(scene, plan.step);
    for (const PlannedTerm& t : plan.terms) left_out += !t.kept && t.name != "inertia";
    for (std::uint64_t j = 0; j < 2; ++j) {
      const State start = draw_start(scene, 1000 + k, j);
      const std::vector<Pose> hand = motion(scene, start, 2 * k + j);
      const SampledRun exact = sample_run(full, start, hand, scene.limits.force);
      const SampledRun run = sample_run(planned, start, hand, INFINITY);
      const double error = run_error(run, exact, hand, scene.world);
      EXPECT_LE(error, tolerance) << "scene " << k << ", motion " << j;
    }
  }
  // It does leave things out: a test that compares the full model to itself would tell nothing.
  EXPECT_GE(left_out, kScenes / 40);
}

// In, pressed against the wall, and out while pressed: the fibre slips out of the liquid the faster
// the less of it is left inside.
std::vector<Pose> pressed_out(const Scene& scene) {
  const double c = scene.world.annulus.clearance(), depth = 0.5 * scene.success.depth;
  const double push = c + 0.5 * scene.limits.force / scene.world.holder.stiffness(1, 1);
  std::vector<Pose> hand = {testing::pose(2e-6, 0.2 * c, 0) - scene.world.holder.sag};
  for (const Pose& tip :
       {testing::pose(-depth, 0, 0), testing::pose(-depth, 0.8 * push, -0.6 * push),
        testing::pose(2e-6, 0.8 * push, -0.6 * push)}) {
    const Pose from = hand.back(), move = tip - scene.world.holder.sag - from;
    const double steps = std::ceil(move.head<3>().norm() / (1e-3 * 0.8 * scene.limits.speed));
    for (double n = 1; n <= steps; ++n) hand.push_back(from + n / steps * move);
  }
  return hand;
}

TEST(PlanAtLength, IsRightForAFibreThatIsPulledOutOfALiquidWhilePressed) {
  for (std::uint64_t k = 0; k < kScenes / 20; ++k) {
    RandomStream random(31, k, Draw::start);
    const auto decades = [&](double low, double high) {
      return low * std::pow(high / low, random.uniform());
    };
    Json d = testing::paper().document();
    d["ferrule"]["bore_diameter_um"] = 125 + decades(0.4, 4);
    d["laws"] = {{"electrostatic", {{"form", "printed"}, {"voltage_V", decades(0.1, 1)}}},
                 {"drag", {{"form", "corrected"}, {"viscosity_Pa_s", decades(1e-3, 10)}}}};
    d["holder"]["stiffness_N_m"] = decades(0.1, 20);
    d["dynamics"] = "quasi_static";
    d["step_s"] = 5e-4;
    d["limits"]["force_uN"] = decades(5, 50);
    d["limits"]["speed_um_s"] = decades(3, 70);
    d["success"]["depth_um"] = decades(5, 30);
    const Scene scene = parse_scene(d, "random scene");
    const Plan plan = make_plan(scene, 0.5);
    const std::vector<Pose> hand = pressed_out(scene);
    const State start = at_rest(scene.world, hand.front() + scene.world.holder.sag);
    const SampledRun exact = sample_run(full_model(scene, 2e-5), start, hand, scene.limits.force);
    const SampledRun run =
        sample_run(parse_scene(plan.document, "planned").world, start, hand, INFINITY);
    EXPECT_LE(run_error(run, exact, hand, scene.world), plan.error_bound) << "scene " << k;
  }
}

TEST(PlanAtLength, OfEveryShippedSceneReachesAHundredth) {
  for (const std::string& name : shipped_scenes())
    EXPECT_LE(make_plan(load_scene(name), 0.01).error_bound, 0.01) << name;
}

Scene random_scene_in_a_liquid(std::uint64_t k) {
  RandomStream random(41, k, Draw::start);
  const auto decades = [&](double low, double high) {
    return low * std::pow(high / low, random.uniform());
  };
  Json d = testing::paper().document();
  d["ferrule"]["bore_diameter_um"] = 125 + decades(0.6, 3);
  d["laws"] = {{"friction", {{"form", "corrected"}, {"burgers_nm", decades(0.05, 1)}}},
               {"adhesion",
                {{"form", "corrected"},
                 {"work_of_adhesion_J_m2", decades(1e-3, 0.1)},
                 {"maugis_lambda", decades(0.2, 5)}}},
               {"drag", {{"form", "corrected"}, {"viscosity_Pa_s", decades(1e-2, 10)}}}};
  d["holder"]["stiffness_N_m"] = decades(0.5, 20);
  d["dynamics"] = "quasi_static";
  d["start"] = {{"distance_um", 2},
                {"lateral_mean_um", {0, 0}},
                {"lateral_sd_um", decades(0.1, 2)},
                {"tilt_sd_mrad", 1}};
  d["limits"] = {{"force_uN", 50}, {"speed_um_s", decades(3, 50)}, {"time_s", 60}};
  d["success"] = {{"depth_um", decades(3, 10)}};
  return parse_scene(d, "random scene");
}

// The samples after `now`, which moves on.
SampledRun run_from(StepResult& now, const World& world, const std::vector<Pose>& hand) {
  SampledRun run;
  for (const Pose& command : hand) {
    step_on(world, command, 1e-3, now);
    run.tip.push_back(now.state.tip.head<3>());
    run.force.push_back(now.holder.head<3>());
  }
  return run;
}

// A fibre that rubs or adheres in a liquid ends elsewhere after a snap whatever the step is.
// Between such events, along motions that the planner has not seen, it moves as in much finer
// steps.
TEST(PlanAtLength, StepsAreRightForAFibreThatRubsInALiquid) {
  std::size_t reached = 0, stretches = 0, within = 0;
  for (std::uint64_t k = 0; k < kScenes / 8; ++k) {
    const Scene scene = random_scene_in_a_liquid(k);
    const Plan plan = make_plan(scene, 0.01 + 0.005 * static_cast<double>(k));
    if (plan.error_bound > plan.tolerance) continue;  // it says so
    ++reached;
    const World planned = parse_scene(plan.document, "planned").world;
    const World full = full_model(scene, plan.step / 20);
    StepResult now(draw_start(scene, 1000 + k, 0));
    const std::vector<Pose> hand = motion(scene, now.state, k);
    constexpr std::ptrdiff_t length = 100;
    for (std::ptrdiff_t from = 0; from + length < std::ssize(hand); from += length) {
      const std::vector<Pose> part(hand.begin() + from, hand.begin() + from + length);
      StepResult exact_now(now.state);
      const SampledRun exact = run_from(exact_now, full, part);
      const SampledRun run = run_from(now, planned, part);
      ++stretches;
      within += run_error(run, exact, part, scene.world) <= plan.error_bound;
    }
  }
  EXPECT_GE(reached, kScenes / 12);
  EXPECT_GE(stretches, 10 * reached);
  // 95 % of all; a single scene, which is what sanitizers are given, may have more that are not.
  const double least = reached >= 10 ? 0.94 : 0.5;
  EXPECT_GE(static_cast<double>(within), least * static_cast<double>(stretches));
}

INSTANTIATE_TEST_SUITE_P(Quarters, PlanOfRandomScenesAtLength,
                         ::testing::Range<std::uint64_t>(0, 4));

}  // namespace
}  // namespace ferrule
