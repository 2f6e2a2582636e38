#include "sim/terms/particle_depth.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/analysis/gap_forces.hpp"
#include "sim/base/random.hpp"
#include "sim/solver/step.hpp"
#include "sim/terms/potential.hpp"
#include "tests/closed_motion.hpp"
#include "tests/compare.hpp"
#include "tests/energy_derivatives.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;
using testing::kFibreRadius;

constexpr double kClearance = 0.5e-6;

std::string bump(double height_um, double at_um, double degrees) {
  return "laws.particle={\"form\":\"corrected\",\"height_um\":" + std::to_string(height_um) +
         ",\"at_um\":" + std::to_string(at_um) + ",\"direction_deg\":" + std::to_string(degrees) +
         "}";
}

// How deep it is, by all places along the fibre, whose rim is a parabola as the header says.
double deepest(const Particle& law, double edge, double cleave, const PoseVector& tip) {
  const double lean = law.outward.dot(tip.t), h = law.height;
  const double begins = tip.x + edge - (kFibreRadius - edge) * (lean + cleave);
  double most = -INFINITY;
  for (int i = -40000; i <= 40000; ++i) {
    const double x = -law.depth + 2e-4 * i * (h + edge);
    double there = law.outward.dot(tip.e) + (x - tip.x) * lean + h -
                   (x + law.depth) * (x + law.depth) / (2 * h) - kClearance;
    if (x < begins) {
      if (edge == 0) continue;
      there -= (begins - x) * (begins - x) / (2 * edge);
    }
    most = std::max(most, there);
  }
  return most;
}

TEST(ParticleDepth, IsThatWhereTheFibreIsDeepest) {
  RandomStream random(15, 0, Draw::plan);
  int on_rim = 0, on_side = 0;
  for (int n = 0; n < 150; ++n) {
    const double edge = n % 3 ? 3e-6 * random.uniform() : 0;
    const double h = 0.1e-6 + 2e-6 * random.uniform(), at = 8e-6 + 20e-6 * random.uniform();
    World world = testing::bare({bump(1e6 * h, 1e6 * at, 360 * random.uniform())}).world;
    world.end.edge = edge;
    world.end.cleave = 2e-2 * Vector2d(random.normal(), random.normal());
    const Particle& law = *world.laws.particle;
    PoseVector tip(-60e-6 * random.uniform(), 1e-6 * Vector2d(random.normal(), random.normal()),
                   1e-3 * Vector2d(random.normal(), random.normal()));
    if (n % 2) tip.x = -at + 3 * (h + edge) * (random.uniform() - 0.5);
    const double cleave = law.outward.dot(world.end.cleave);
    const ParticleDepth there = particle_depth(world, tip);
    const double expected = deepest(law, edge, cleave, tip);
    if (expected > -h - kClearance) {
      EXPECT_NEAR(there.value, expected, 1e-3 * h) << n;
    }
    (there.slope.x == -law.outward.dot(tip.t) ? on_side : on_rim)++;
    const double units[5] = {1e-11, 1e-11, 1e-11, 1e-7, 1e-7};
    for (int i = 0; i < 5; ++i) {
      Pose step = Pose::Zero();
      step[i] = units[i];
      const ParticleDepth up = particle_depth(world, Pose(tip.full() + step));
      const ParticleDepth down = particle_depth(world, Pose(tip.full() - step));
      EXPECT_NEAR((up.value - down.value) / (2 * units[i]), there.slope.full()[i],
                  1e-3 * (i < 3 ? 1 : kFibreRadius));
      const Pose column = (up.slope.full() - down.slope.full()) / (2 * units[i]);
      EXPECT_LE((column - there.curve.full().col(i)).norm(),
                1e-3 * there.curve.full().norm() + 1e-6)
          << n << " " << i;
    }
  }
  EXPECT_GT(on_rim, 30);
  EXPECT_GT(on_side, 30);
}

// On bore and cone no upright end is in one that is as shallow as it may be; nearer to the mouth
// some would be.
TEST(ParticleDepth, AnEndThatIsNotInTheBoreIsNotInIt) {
  RandomStream random(15, 1, Draw::plan);
  int wrong = 0;
  for (int n = 0; n < 200; ++n) {
    const double h = 2e-6 * random.uniform(), edge = n % 2 ? 5e-6 * random.uniform() : 0;
    const double tangent = 5 * random.uniform(), least = shallowest(h, edge, tangent);
    const auto most = [&](double depth) {
      double deep = -INFINITY;
      for (double x = 0; x < 60e-6; x += 0.05e-6)  // of the rim
        deep = std::max(deep, x * tangent + h - (x + depth) * (x + depth) / (2 * (h + edge)));
      return deep;
    };
    EXPECT_LE(most(least), 1e-12);
    wrong += most(0.9 * least) > 1e-3 * h;
  }
  EXPECT_GT(wrong, 150);
}

TEST(ParticleDepth, GradientAndHessianOfTheEnergyAreItsDerivatives) {
  int touched = 0;
  for (const char* name : {"bench", "sticky", "epoxy", "paper"})
    for (const double at : {38.0, 39.9, 41.0}) {
      const World world =
          load_scene(name, {bump(0.7, at, 20), "laws.friction=null", "fibre.edge_um=1",
                            "ferrule.ovality_um=0.1", "ferrule.ovality_direction_deg=70"})
              .world;
      for (const double y : {-0.1e-6, 0.2e-6}) {
        State state = at_rest(world, testing::pose(-40e-6, y, 0.1e-6, 1e-3, -5e-4));
        const FrozenCoefficients frozen = freeze(world, state, state.command, 1e-3);
        touched += particle_depth(world, state.tip).value > 0;
        SCOPED_TRACE(name + (" at " + std::to_string(at) + ", " + std::to_string(y)));
        testing::expect_energy_derivatives(world, frozen, state.tip, 40e-6,
                                           {1e-11, 1e-11, 1e-11, 1e-7, 1e-7});
      }
    }
  EXPECT_GT(touched, 8);
}

// An upright rigid fibre in a soft hand passes it on the room c - h, or shifts aside by h - c; what
// is higher than 2 c stays before it. Nowhere is a force that is not balanced.
TEST(ParticleDepth, TakesUpClearance) {
  for (const double h : {0.3, 0.7, 0.95, 1.1, 3.0}) {
    const World world = testing::bare({bump(h, 12, 90), "holder.tilt_stiffness_N_m_rad=1e6"}).world;
    StepResult r(at_rest(world, testing::pose(1e-6, 0, 0)));
    const State& state = r.state;
    for (int n = 1; n <= 2500; ++n) {
      step_on(world, testing::pose(1e-6 - n * 1e-8, 0, 0), 1e-3, r);
      EXPECT_LT((forces(world, r).sum(state.tip) - r.holder).norm(),
                1e-4 * r.holder.norm() + 1e-13);
    }
    const bool in = h < 1;
    EXPECT_EQ(state.tip[0] < -20e-6, in) << h;
    const Vector3d by_particle = forces(world, r).force(Term::particle);
    const double push = by_particle.z();
    EXPECT_LE(push, 0) << h;
    EXPECT_EQ(push<0, h> 0.5) << h;
    if (!in) {
      EXPECT_GT(by_particle.x(), 1e-6) << h;
      EXPECT_GT(state.tip[0], -12e-6);
    } else {
      EXPECT_NEAR(state.tip[2], -std::max(0.0, 1e-6 * h - kClearance), 2e-9) << h;
    }
  }
}

// The widest place of an oval bore has room for one that is q higher.
TEST(ParticleDepth, KnowsTheOvalBore) {
  const auto depth = [](double degrees) {
    const World world = testing::bare({bump(0.6, 12, degrees), "ferrule.ovality_um=0.2",
                                       "ferrule.ovality_direction_deg=30"})
                            .world;
    return particle_depth(world, testing::pose(-40e-6, 0, 0)).value;
  };
  EXPECT_CLOSE(depth(30), 0.05e-6, 1e-6);
  EXPECT_CLOSE(depth(120), 0.15e-6, 1e-6);
}

TEST(ParticleDepth, NoClosedMotionGainsEnergy) {
  for (std::uint64_t k = 0; k < 20; ++k) {
    RandomStream random(16, k, Draw::start);
    std::vector<std::string> settings = {
        bump(0.2 + random.uniform(), 3 + 10 * random.uniform(), 360 * random.uniform())};
    if (k % 2) settings.emplace_back("fibre.edge_um=2");
    const Scene scene = k % 4 == 0   ? testing::bare(settings)
                        : k % 4 == 1 ? load_scene("sticky", settings)
                                     : load_scene("bench", settings);
    SCOPED_TRACE(k);
    testing::expect_no_energy_gained(scene.world, testing::pose(0.5e-6, 0, 0),
                                     {150, 260, 300, 1.2e-7, 0.05e-6, 1e-5}, random);
  }
}

// The states of a motion in and aside.
std::vector<StateRow> states(const World& world, double mirror = 1) {
  StepResult now(at_rest(world, testing::pose(1e-6, 1e-7, mirror * 2e-7, 1e-4, mirror * -2e-4)));
  State& state = now.state;
  Pose hand = state.command;
  std::vector<StateRow> rows;
  for (int n = 0; n < 1200; ++n) {
    hand[0] -= n < 900 ? 3e-8 : 0;
    hand[2] += n < 600 ? 0 : mirror * 3e-9;
    step_on(world, hand, 1e-3, now);
    rows.push_back(to_row(state));
  }
  return rows;
}

TEST(ParticleDepth, NoneIsAsIfThereWereNoLaw) {
  for (const char* name : {"bench", "epoxy", "paper"})
    EXPECT_EQ(states(load_scene(name).world), states(load_scene(name, {bump(0, 0, 0)}).world));
}

TEST(ParticleDepth, AMirroredOneDoesTheSameToTheLastBit) {
  const char* level = "laws.gravity=null";
  const auto here = states(load_scene("bench", {bump(0.7, 9, 40), level}).world);
  const auto there = states(load_scene("bench", {bump(0.7, 9, -40), level}).world, -1);
  const auto without = states(load_scene("bench", {level}).world);
  bool any = false;
  for (std::size_t n = 0; n < here.size(); ++n) {
    for (const int across : {2, 4}) EXPECT_EQ(here[n][across], -there[n][across]);
    for (const int along : {0, 1, 3}) EXPECT_EQ(here[n][along], there[n][along]);
    any = any || here[n] != without[n];
  }
  EXPECT_TRUE(any);
}

// Smooth intervals are followed along the tangent, but not where it is near.
TEST(ParticleDepth, IsNoPartOfATangent) {
  const Scene scene =
      load_scene("bench", {bump(0.6, 9, 40), R"(tangent={"tip_nm":5,"force_uN":1})"});
  StepResult r(at_rest(scene.world, testing::pose(1e-6, 0, 0)));
  Pose hand = r.state.command;
  int followed = 0, touching = 0;
  for (int n = 0; n < 1500; ++n) {
    hand[0] -= 3e-8;
    step_on(scene.world, hand, 1e-3, r);
    followed += r.evaluations == 0;
    if (particle_depth(scene.world, r.state.tip).value < 0) continue;
    ++touching;
    EXPECT_GT(r.evaluations, 0);
  }
  EXPECT_GT(followed, 50);
  EXPECT_GT(touching, 50);
}

TEST(ParticleDepth, IsInTheForcesAtAGap) {
  const World world = load_scene("bench", {bump(0.6, 10, 0)}).world;
  const auto force = [&](double gap, double length, double tilt) {
    return gap_forces(world, {gap, length, {}, tilt, 0})[Term::particle];
  };
  EXPECT_EQ(force(0.7e-6, 100e-6, 0), 0);
  EXPECT_EQ(force(0.3e-6, 5e-6, 0), 0);
  const double modulus = world.laws.particle->reduced_modulus;
  const double expected = modulus * std::sqrt(0.6e-6) * std::pow(0.1e-6, 1.5);
  EXPECT_CLOSE(force(0.5e-6, 100e-6, 0), expected, 1e-9);
  EXPECT_CLOSE(force(0.41e-6, 100e-6, 1e-3), expected, 1e-9);
}

}  // namespace
}  // namespace ferrule
