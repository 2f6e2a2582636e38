#include "sim/geometry/face_support.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/base/random.hpp"
#include "sim/solver/step.hpp"
#include "sim/terms/potential.hpp"
#include "tests/closed_motion.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;
using testing::kFibreRadius;

bool supported(const Vector2d& p, const Vector2d& e, double opening, double radius = kFibreRadius) {
  return p.norm() <= radius && (p + e).norm() >= opening;
}

// The lowest of all points of the crescent: of its area, its rim and the opening's edge.
double lowest(const Vector2d& e, double opening, const Vector2d& slope,
              double radius = kFibreRadius) {
  double most = -INFINITY;
  constexpr int kPoints = 200000;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * pi * i / kPoints;
    const Vector2d u(std::cos(angle), std::sin(angle));
    for (const Vector2d& p : {Vector2d((1 - 1e-12) * radius * u), Vector2d(opening * u - e)})
      if (supported(p, e, (1 - 1e-12) * opening, radius)) most = std::max(most, p.dot(slope));
  }
  for (int i = -60; i <= 60; ++i)
    for (int j = -60; j <= 60; ++j) {
      const Vector2d p = radius / 60 * Vector2d(i, j);
      if (supported(p, e, opening, radius)) most = std::max(most, p.dot(slope));
    }
  return most;
}

TEST(FaceSupport, ATiltedEndRestsAtTheLowestPointOfTheCrescent) {
  RandomStream random(8, 0, Draw::plan);
  int corners = 0;
  for (int n = 0; n < 60; ++n) {
    const double opening = n % 3 ? 63e-6 : 125e-6, least = opening - kFibreRadius;
    const double off = least + (n % 2 ? 3e-6 : 150e-6) * random.uniform();
    const double angle = 2 * pi * random.uniform(), lean = 2 * pi * random.uniform();
    const double tilt = 1e-2 * (0.2 + random.uniform());
    const Vector2d e = off * Vector2d(std::cos(angle), std::sin(angle));
    const Vector2d slope = tilt * Vector2d(std::cos(lean), std::sin(lean));
    const FaceSupport support(kFibreRadius, opening, e);
    ASSERT_TRUE(support.any());
    const FaceSupport::Rest rest = support.rest(slope);
    const double found = lowest(e, opening, slope);
    // Smoothing lifts it by no more than kRestTilt r/2 4.
    EXPECT_LE(std::abs(rest.ahead - found), 2.1 * kRestTilt * kFibreRadius) << n;
    EXPECT_LE(std::abs(rest.point.dot(slope) - found), 2.1 * kRestTilt * kFibreRadius) << n;
    corners += rest.turning.norm() == 0;
  }
  EXPECT_GT(corners, 10);
}

// 15 um aside over a sharp bore of 126 um: supported for |phi| < 95 degrees.
TEST(FaceSupport, TellsOfTheHoleOnlyWhereTheTiltLetsIt) {
  const Vector2d e(15e-6, 0);
  const FaceSupport support(kFibreRadius, 63e-6, e);
  for (int degrees = 0; degrees <= 180; degrees += 5) {
    const double angle = degrees * pi / 180;
    const Vector2d slope = 0.01 * Vector2d(std::cos(angle), std::sin(angle));
    const Vector2d p = support.rest(slope).point;
    const double rests = std::atan2(p.y(), p.x()) * 180 / pi;
    EXPECT_TRUE(degrees == 180 || std::abs(rests - std::min(degrees, 95)) < 0.5) << degrees;
    EXPECT_CLOSE(p.norm(), degrees == 180 ? std::abs(p.x()) : kFibreRadius, 1e-9);
  }
}

TEST(FaceSupport, AnUprightEndRestsAtTheCentroidOfTheCrescent) {
  for (const double opening : {63e-6, 125e-6})
    for (const double more : {0.3e-6, 15e-6, 60e-6, 200e-6}) {
      const Vector2d e = (opening - kFibreRadius + more) * Vector2d(0.6, -0.8);
      Vector2d sum = Vector2d::Zero();
      double count = 0;
      // In polar coordinates, finer at the rim, where the thin crescents are.
      constexpr int kRings = 1500, kAngles = 1500;
      for (int i = 0; i < kRings; ++i)
        for (int j = 0; j < kAngles; ++j) {
          const double part = 1 - std::pow((i + 0.5) / kRings, 3);
          const double width = 3 * std::pow((i + 0.5) / kRings, 2) / kRings;
          const double angle = 2 * pi * (j + 0.5) / kAngles;
          const Vector2d p = part * kFibreRadius * Vector2d(std::cos(angle), std::sin(angle));
          if (!supported(p, e, opening)) continue;
          sum += part * width * p;
          count += part * width;
        }
      const FaceSupport::Rest rest = FaceSupport(kFibreRadius, opening, e).rest(Vector2d::Zero());
      EXPECT_LT((rest.point - sum / count).norm(), 3e-3 * kFibreRadius) << opening << " " << more;
      EXPECT_EQ(rest.ahead, 0);
    }
  EXPECT_FALSE(FaceSupport(kFibreRadius, 63e-6, Vector2d(0.49e-6, 0)).any());
}

TEST(FaceSupport, RestsWhereItsHeightChangesWithTheSlope) {
  RandomStream random(9, 0, Draw::plan);
  for (int n = 0; n < 400; ++n) {
    const Vector2d e = 40e-6 * random.uniform() * Vector2d(0.8, 0.6) + Vector2d(0.6e-6, 0);
    const FaceSupport support(kFibreRadius, 63e-6, e);
    const Vector2d slope =
        std::pow(10.0, -7 + 5 * random.uniform()) * Vector2d(random.normal(), random.normal());
    const FaceSupport::Rest rest = support.rest(slope);
    const double h = 1e-4 * slope.norm();
    for (int i = 0; i < 2; ++i) {
      Vector2d step = Vector2d::Zero();
      step[i] = h;
      const auto up = support.rest(slope + step), down = support.rest(slope - step);
      EXPECT_LE(std::abs((up.ahead - down.ahead) / (2 * h) - rest.point[i]), 1e-3 * kFibreRadius);
    }
    EXPECT_LE(std::abs(rest.turning(0, 1) - rest.turning(1, 0)), 1e-12 * rest.turning.norm());
  }
}

// Down to thin crescents, whose corners move far for little.
TEST(FaceSupport, ChangesItsHeightAsItMovesOverTheOpening) {
  RandomStream random(14, 0, Draw::plan);
  int corners = 0;
  for (int n = 0; n < 2000; ++n) {
    const double opening = n % 2 ? 63e-6 : 125e-6, angle = 2 * pi * random.uniform();
    const double off = opening - kFibreRadius + std::pow(10.0, -8 + 4.2 * random.uniform());
    const Vector2d e = off * Vector2d(std::cos(angle), std::sin(angle));
    const Vector2d slope =
        std::pow(10.0, -6 + 5 * random.uniform()) * Vector2d(random.normal(), random.normal());
    const auto rest = [&](const Vector2d& at) {
      return FaceSupport(kFibreRadius, opening, at).rest(slope);
    };
    corners += rest(e).turning.norm() == 0;
    const double h = 1e-5 * (off - opening + kFibreRadius);
    for (int i = 0; i < 2; ++i) {
      Vector2d step = Vector2d::Zero();
      step[i] = h;
      const double by = (rest(e + step).ahead - rest(e - step).ahead) / (2 * h);
      EXPECT_LE(std::abs(by - rest(e).by_e[i]), 1e-3 * rest(e).by_e.norm() + 1e-4 * slope.norm())
          << n << " " << i;
    }
  }
  EXPECT_GT(corners, 300);
}

Scene cleaved(double degrees, double direction, std::vector<std::string> more = {}) {
  std::vector<std::string> settings = {"fibre.cleave_deg=" + std::to_string(degrees),
                                       "fibre.roll_deg=0",
                                       "fibre.cleave_direction_deg=" + std::to_string(direction)};
  settings.insert(settings.end(), more.begin(), more.end());
  return testing::bare(settings);
}

// Rim points at every angle: against the face the end is as deep as its lowest supported point, and
// the wrench is that of a force there.
TEST(Cleave, TheEndOnTheFaceIsAsDeepAsItsLowestSupportedPoint) {
  RandomStream random(10, 0, Draw::plan);
  for (int n = 0; n < 100; ++n) {
    const Scene scene = cleaved(random.uniform(), 360 * random.uniform());
    const World& world = scene.world;
    State state;
    state.side = EdgeSide::face;
    state.tip << 0.5e-6, 20e-6 * random.normal(), 20e-6 * random.normal(), 2e-3 * random.normal(),
        2e-3 * random.normal();
    const Vector2d e = state.tip.segment<2>(1), slope = state.tip.tail<2>() + world.end.cleave;
    if (e.norm() < 1e-6) continue;
    const ContactSide side = contact_side(world, state.tip, state.side);
    if (side.side != EdgeSide::face) continue;
    const ContactDepth depth = contact_depths(world, side, state.tip)[kEnd];
    EXPECT_LE(std::abs(depth.value -
                       (lowest(e, 63e-6, slope, kFibreRadius - world.end.edge) - state.tip[0])),
              2.1 * kRestTilt * kFibreRadius);
    PointForce push{depth.normal(state.tip.tail<2>()), depth.point};
    const PoseVector slope_of = depth.by_pose(state.tip.tail<2>());
    EXPECT_LT((push.wrench(state.tip) + slope_of.full()).tail<2>().norm(), 1e-9 * kFibreRadius);
  }
}

// On face, cone, wall and the edges between, down to thin crescents, of sharp and rounded ends.
TEST(Cleave, GradientAndHessianOfTheEnergyAreItsDerivatives) {
  RandomStream random(11, 0, Draw::plan);
  int tried = 0;
  for (const char* lead_in :
       {"ferrule.lead_in=null", "ferrule.lead_in={\"angle_deg\":60,\"diameter_um\":250}"})
    for (int n = 0; n < 240; ++n) {
      std::vector<std::string> settings = {lead_in};
      if (n % 4 > 1) settings.emplace_back("fibre.edge_um=3");
      const World world = cleaved(0.8, 360 * random.uniform(), settings).world;
      State state;
      const bool face = n % 2;
      state.side = face ? EdgeSide::face : EdgeSide::throat;
      const double room = face ? world.profile.mouth_radius() - kFibreRadius + world.end.edge : 0;
      const double reach = room + std::pow(10.0, -7 + 2.3 * random.uniform());
      const double angle = 2 * pi * random.uniform();
      state.tip << world.profile.lead_in_length, reach * std::cos(angle), reach * std::sin(angle),
          1e-3 * random.normal(), 1e-3 * random.normal();
      FrozenCoefficients frozen = freeze(world, state, state.tip, 1e-3);
      frozen.contact.side = state.side;
      const auto energy = [&](const Pose& tip) { return Potential(world, frozen, tip); };
      Pose at = state.tip;  // until it touches by some nanometres
      for (int k = 0; k < 60; ++k) {
        const ContactDepth depth = energy(at).depth[kEnd];
        if (!std::isfinite(depth.value) || std::abs(depth.value - 20e-9) < 1e-10) break;
        if (depth.slope[0] < -0.05)
          at[0] -= (depth.value - 20e-9) / depth.slope[0];
        else
          at.segment<2>(1) -= (depth.value - 20e-9) * depth.slope.tail<2>();
      }
      const Potential here = energy(at);
      if (!(std::abs(here.depth[kEnd].value - 20e-9) < 10e-9)) continue;
      ++tried;
      const Pose gradient = here.gradient.full(), units = testing::pose(1, 1, 1, 2e4, 2e4) * 1e-9;
      const Matrix5 hessian = units.asDiagonal() * here.hessian.full() * units.asDiagonal();
      for (int i = 0; i < 5; ++i) {
        Pose step = Pose::Zero();
        step[i] = 1e-2 * units[i];
        const Potential up = energy(at + step), down = energy(at - step);
        EXPECT_LE(std::abs((up.value - down.value) / (2e-2) - gradient[i] * units[i]),
                  1e-4 * here.force_scale * 1e-9)
            << n << " " << i;
        const Pose column = (up.gradient.full() - down.gradient.full()) / 2e-2;
        EXPECT_LE((units.asDiagonal() * column - hessian.col(i)).norm(), 1e-2 * hessian.norm())
            << n << " " << face << " " << i;
      }
    }
  EXPECT_GT(tried, 250);
}

// The lowest of the crescent over a sharp bore's edge: of its corners and sides.
double lowest_on_edges(const Vector2d& e, const Vector2d& slope) {
  double most = -INFINITY;
  constexpr int kPoints = 8000;
  for (int i = 0; i < kPoints; ++i) {
    const double angle = 2 * pi * i / kPoints;
    const Vector2d u(std::cos(angle), std::sin(angle)), rim = kFibreRadius * u,
                                                        edge = 63e-6 * u - e;
    if ((rim + e).norm() >= 63e-6) most = std::max(most, rim.dot(slope));
    if (edge.norm() <= kFibreRadius) most = std::max(most, edge.dot(slope));
  }
  return most;
}

// A rigid upright fibre goes into a sharp bore from within the clearance, cleaved or not, unless
// its leading side is over the opening: then it rests on two points of the opening's edge, which
// push a soft hand towards the axis.
TEST(Cleave, ASharpBoreTakesAnUprightFibreFromWithinTheClearance) {
  for (const double direction : {0.0, 60.0})
    for (const double offset : {0.5, 0.98, 3.0, 30.0}) {
      const World world = cleaved(1, direction, {"holder.tilt_stiffness_N_m_rad=1e6"}).world;
      StepResult now(at_rest(world, testing::pose(3e-6, 0.5e-6 * offset, 0)));
      State& state = now.state;
      for (int n = 1; n <= 1400; ++n)
        step_on(world, testing::pose(3e-6 - n * 5e-9, 0.5e-6 * offset, 0), 1e-3, now);
      EXPECT_EQ(state.tip[0] < -2e-6, offset < 1) << direction << " " << offset;
      EXPECT_TRUE(offset < 1 || state.tip[0] > -1.2e-6) << direction << " " << offset;
    }
}

// Farther out it slides in where its lowest supported point, looked for among all, falls towards
// the bore: the end is lowered by a soft hand and goes down in the energy of that hand alone.
bool slides_in(const Vector2d& hand, const Vector2d& slope, double lowered) {
  constexpr double kStep = 20e-9, kLower = 100e-9;
  Vector2d e = hand;
  const auto energy = [&](const Vector2d& at, double x) {
    const double pressed = std::max(0.0, lowest_on_edges(at, slope) - x);
    return 0.5 * pressed * pressed + 0.5 * (at - hand).squaredNorm();
  };
  for (double x = 2 * kFibreRadius * slope.norm(); x > -lowered; x -= kLower)
    for (double least = energy(e, x), stride = kStep; stride > 1e-9;) {
      bool lower = false;
      for (int k = 0; k < 8 && !lower; ++k) {
        const Vector2d to = e + stride * Vector2d(std::cos(k * pi / 4), std::sin(k * pi / 4));
        if (to.norm() < 0.5e-6) return true;
        const double there = energy(to, x);
        lower = there < least - 1e-22;
        if (!lower) continue;
        least = there;
        e = to;
      }
      if (!lower) stride *= 0.5;
    }
  return false;
}

TEST(CleaveAtLength, FartherOutASharpBoreTakesItWhereItsLowestPointSlidesIn) {
  int in = 0;
  for (const double offset : {1.5, 3.0, 6.0})
    for (int k = 0; k < 4; ++k) {
      const double angle = 0.1 + k * pi / 2, degrees = 0.5 * pi / 180;
      const Vector2d at = 0.5e-6 * offset * Vector2d(std::cos(angle), std::sin(angle));
      const World world = cleaved(0.5, 0, {"holder.tilt_stiffness_N_m_rad=1e6"}).world;
      StepResult now(at_rest(world, testing::pose(3e-6, at.x(), at.y())));
      State& state = now.state;
      for (int n = 1; n <= 1200; ++n)
        step_on(world, testing::pose(3e-6 - n * 5e-9, at.x(), at.y()), 1e-3, now);
      const bool expected = slides_in(at, {std::tan(degrees), 0}, 3e-6);
      EXPECT_EQ(state.tip[0] < -2e-6, expected) << offset << " " << k;
      in += expected;
    }
  EXPECT_GT(in, 2);
  EXPECT_LT(in, 10);
}

// The face of a cleaved end meets the ferrule's before its centre does, by r times the slope.
TEST(Cleave, TheLeadingPointTouchesFirst) {
  const World world = cleaved(1, 90, {"holder.tilt_stiffness_N_m_rad=1e6"}).world;
  StepResult now(at_rest(world, testing::pose(5e-6, 40e-6, 0)));
  State& state = now.state;
  double touched = 0;
  for (int n = 1; n <= 1000 && touched == 0; ++n) {
    step_on(world, testing::pose(5e-6 - n * 5e-9, 40e-6, 0), 1e-3, now);
    if (state.contact[kEnd].closed) touched = state.tip[0];
  }
  EXPECT_NEAR(touched, kFibreRadius * std::tan(pi / 180), 2e-8);
}

// A hand that wanders on and off the face and over the opening, and comes back.
TEST(Cleave, NoClosedMotionGainsEnergy) {
  for (std::uint64_t k = 0; k < 30; ++k) {
    RandomStream random(12, k, Draw::start);
    const Scene scene = cleaved(2 * random.uniform(), 360 * random.uniform());
    SCOPED_TRACE(k);
    testing::expect_no_energy_gained(scene.world, testing::pose(5e-6, 10e-6, 0),
                                     {100, 380, 400, 1e-7, 0.3e-6, 2e-4}, random);
  }
}

}  // namespace
}  // namespace ferrule
