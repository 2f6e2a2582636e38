#include "sim/geometry/contact_depth.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "sim/analysis/hand_work.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"
#include "tests/closed_motion.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// The rim of the end is as deep in the cone as the deepest of its circles, all of them looked at.
TEST(ContactDepth, OnTheConeIsThatOfTheDeepestCircleOfTheRim) {
  const World world = load_scene("bench").world;
  const FerruleProfile& profile = world.profile;
  const double rho = world.end.rounding(), lever = world.annulus.fibre_radius - rho;
  RandomStream random(4, 0, Draw::plan);
  int on_cone = 0;
  for (int n = 0; n < 200; ++n) {
    State state;
    state.tip << 5e-6 + 50e-6 * random.uniform(), 1e-5 * random.normal(), 1e-5 * random.normal(),
        2e-3 * random.normal(), 2e-3 * random.normal();
    const PoseVector tip(state.tip);
    const auto depth = contact_depths(world, contact_side(world, state.tip, state.side), tip)[kEnd];
    double deepest = -INFINITY;
    constexpr int kPoints = 20000;
    for (int i = 0; i < kPoints; ++i) {
      const double angle = 2 * std::numbers::pi * i / kPoints;
      const Vector2d u(std::cos(angle), std::sin(angle));
      // Its centre is as far from the bore's axis as lever + u.e, to first order in e.
      const EdgeDepth centre =
          edge_depth(profile, tip.x - lever * u.dot(tip.t), lever + u.dot(tip.e));
      deepest = std::max(deepest, rho + centre.cone);
    }
    if (depth.value == -INFINITY || depth.edge > 0 || depth.slope[0] == 0) continue;
    ++on_cone;
    EXPECT_NEAR(depth.value, deepest, 1e-12);
  }
  EXPECT_GT(on_cone, 50);
}

// Distance of a point outside a convex solid, by its boundary point after point.
double distance_to(const FerruleProfile& profile, double x, double rho) {
  const double L = profile.lead_in_length, R = profile.bore_radius, R_o = profile.mouth_radius();
  const auto to_segment = [&](double x0, double r0, double x1, double r1) {
    const Vector2d a(x0, r0), along = Vector2d(x1, r1) - a, to = Vector2d(x, rho) - a;
    const double part = std::clamp(to.dot(along) / along.squaredNorm(), 0.0, 1.0);
    return (to - part * along).norm();
  };
  double least = std::min(to_segment(-1e-3, R, 0, R), to_segment(L, R_o, L, R_o + 1e-3));
  if (L > 0) least = std::min(least, to_segment(0, R, L, R_o));
  return least;
}

// A slanted end, tilted or cleaved, goes from the cone into the bore point after point of its rim:
// it is as deep as the deepest of them, each no deeper than either surface lets it, and no well
// holds it there.
TEST(ContactDepthAtLength, AtTheThroatIsThatOfTheDeepestPointOfASlantedRim) {
  RandomStream random(14, 0, Draw::plan);
  int near = 0, beyond_either = 0;
  for (int scene = 0; scene < 60; ++scene) {
    const bool cleaved = scene % 2 == 0;
    std::vector<std::string> changed;
    if (cleaved)
      changed.push_back("fibre.cleave_deg=" + std::to_string(0.5 + 3 * random.uniform()));
    const World world = load_scene("bench", changed).world;
    for (int n = 0; n < 100; ++n) {
      const double rho = world.end.rounding(), lever = world.annulus.fibre_radius - rho;
      const double angle = 2 * std::numbers::pi * random.uniform(), off = 2e-6 * random.uniform();
      const double tilts = cleaved ? 1e-3 : 2e-2;
      State state;
      state.tip << 4e-6 * (random.uniform() - 0.75), off * std::cos(angle), off * std::sin(angle),
          tilts * random.normal(), tilts * random.normal();
      const PoseVector tip(state.tip);
      double in_bore = -INFINITY, in_cone = -INFINITY;
      bool outside = true;
      const auto depth_of_circle = [&](double at) {
        const Vector2d u(std::cos(at), std::sin(at));
        const double x = tip.x - lever * u.dot(tip.t + world.end.cleave), y = lever + u.dot(tip.e);
        const EdgeDepth centre = edge_depth(world.profile, x, y);
        outside = outside && centre.throat() < 0;
        in_bore = std::max(in_bore, rho + centre.bore);
        in_cone = std::max(in_cone, rho + centre.cone);
        return rho - distance_to(world.profile, x, y);
      };
      double deepest = -INFINITY, where = 0;
      for (double apart : {1.0, 2e-3, 4e-6}) {  // of half a turn, about the deepest so far
        const double middle = where;
        for (int i = -1000; i <= 1000; ++i) {
          const double at = middle + std::numbers::pi * apart * 1e-3 * i, d = depth_of_circle(at);
          if (d > deepest) deepest = d, where = at;
        }
      }
      if (!outside || deepest < -rho) continue;
      ++near;
      const auto depth =
          contact_depths(world, contact_side(world, state.tip, state.side), tip)[kEnd];
      EXPECT_NEAR(depth.value, deepest, 1e-13) << scene << ' ' << n;
      beyond_either += deepest < std::min(in_bore, in_cone) - 100e-9;
    }
  }
  EXPECT_GT(near, 100);
  EXPECT_GT(beyond_either, 50);
}

// Over a cone of 60 degrees r slope tan(30) is more than the clearance from 14 mrad on.
TEST(ContactDepth, ASlantedEndSlidesThroughTheThroat) {
  for (const bool cleaved : {false, true})
    for (const double direction : {0, 60, 90, 135, 180, 270}) {
      std::vector<std::string> settings = {"laws={}"};
      if (cleaved) {
        settings.emplace_back("fibre.cleave_deg=2");
        settings.push_back("fibre.cleave_direction_deg=" + std::to_string(direction));
      }
      const World world = load_scene("bench", settings).world;
      const double angle = direction * std::numbers::pi / 180, tilt = cleaved ? 0 : 0.035;
      StepResult now(at_rest(
          world, testing::pose(5e-6, 1e-6, 0, tilt * std::cos(angle), tilt * std::sin(angle))));
      const State& state = now.state;
      const Pose start = state.command;
      double most = 0;
      for (int n = 1; n <= 1500; ++n) {
        step_on(world, start - testing::pose(n * 10e-9, 0, 0), 1e-3, now);
        most = std::max(most, std::abs(now.holder[0]));
      }
      EXPECT_LT(state.tip[0], -9e-6) << cleaved << " " << direction;
      EXPECT_LT(most, 2e-6) << cleaved << " " << direction;
    }
}

Scene rounded(double edge_um, std::vector<std::string> more = {}) {
  std::vector<std::string> settings = {"fibre.edge_um=" + std::to_string(edge_um)};
  settings.insert(settings.end(), more.begin(), more.end());
  return testing::bare(settings);
}
constexpr const char* kCone = "ferrule.lead_in={\"angle_deg\":60,\"diameter_um\":250}";

// The rim's circle at every direction, against the solid's boundary.
TEST(ContactDepth, OfARoundedRimIsThatOfItsDeepestCircle) {
  RandomStream random(5, 0, Draw::plan);
  int on_edge = 0, on_cone = 0, in_bore = 0, on_face = 0;
  for (int n = 0; n < 600; ++n) {
    const double edge = std::pow(10.0, -6.3 + 1.3 * random.uniform());
    const bool lead_in = n % 2;
    std::vector<std::string> more = {"fibre.cleave_deg=" + std::to_string(random.uniform())};
    if (lead_in) more.emplace_back(kCone);
    const World world = rounded(1e6 * edge, more).world;
    const FerruleProfile& profile = world.profile;
    const double r = world.annulus.fibre_radius, angle = 2 * std::numbers::pi * random.uniform();
    const double off = world.annulus.clearance() + (n % 3 ? 1.3 : 4) * edge * random.uniform() +
                       (lead_in ? 40e-6 * random.uniform() * random.uniform() : 0);
    State state;
    state.tip << -edge + (lead_in ? 60e-6 : 1.5 * edge) * random.uniform() * random.uniform(),
        off * std::cos(angle), off * std::sin(angle), 5e-4 * random.normal(),
        5e-4 * random.normal();
    const PoseVector tip(state.tip);
    const ContactSide side = contact_side(world, state.tip, state.side);
    const ContactDepth depth = contact_depths(world, side, tip)[kEnd];
    // Only where its circles are outside the solid, and touch or nearly do.
    if (!(depth.value > -3 * edge && depth.value < 0.7 * edge)) continue;
    double deepest = -INFINITY;
    constexpr int kPoints = 20000;
    for (int i = 0; i < kPoints; ++i) {
      const double at = 2 * std::numbers::pi * i / kPoints;
      const Vector2d u(std::cos(at), std::sin(at));
      const double x = tip.x + edge - (r - edge) * u.dot(tip.t + world.end.cleave);
      const double rho = r - edge + u.dot(tip.e + edge * tip.t);
      deepest = std::max(deepest, edge - distance_to(profile, x, rho));
    }
    EXPECT_LE(std::abs(depth.value - deepest), 1e-3 * edge + 2e-10) << n << " " << lead_in;
    on_edge += depth.edge > 0;
    on_cone += lead_in && depth.edge == 0 && depth.slope[0] < 0;
    in_bore += depth.slope[0] == 0;
    on_face += side.side == EdgeSide::face;
  }
  EXPECT_GT(on_edge, 30);
  EXPECT_GT(on_cone, 10);
  EXPECT_GT(in_bore, 2);
  EXPECT_GT(on_face, 30);
}

TEST(ContactDepth, OfARoundedRimHasTheDerivativesThatItSays) {
  RandomStream random(6, 0, Draw::plan);
  int tried = 0;
  for (int n = 0; n < 300; ++n) {
    const double edge = 3e-6;
    std::vector<std::string> more = {"fibre.cleave_deg=0.7"};
    if (n % 2) more.emplace_back(kCone);
    const World world = rounded(3, more).world;
    const double off = 0.5e-6 + edge * random.uniform() + (n % 2 ? 20e-6 * random.uniform() : 0);
    State state;
    state.tip << -edge + (n % 2 ? 40e-6 : 4e-6) * random.uniform(), off, 0.3 * off,
        1e-3 * random.normal(), 1e-3 * random.normal();
    const ContactSide side = contact_side(world, state.tip, state.side);
    const auto at = [&](const Pose& tip) { return contact_depths(world, side, tip)[kEnd]; };
    const ContactDepth depth = at(state.tip);
    if (!(std::abs(depth.value) < 0.5 * edge)) continue;
    ++tried;
    const Pose slope = depth.by_pose(state.tip.tail<2>()).full();
    const double units[5] = {1e-10, 1e-10, 1e-10, 1e-7, 1e-7};
    for (int i = 0; i < 5; ++i) {
      Pose step = Pose::Zero();
      step[i] = units[i];
      const double by = (at(state.tip + step).value - at(state.tip - step).value) / (2 * units[i]);
      EXPECT_LE(std::abs(by - slope[i]), (i < 3 ? 1 : 62.5e-6) * 2e-4) << n << " " << i;
    }
    PointForce push{depth.normal(state.tip.tail<2>()), depth.point};
    EXPECT_LT((push.wrench(state.tip) + slope).tail<2>().norm(), 1e-9 * 62.5e-6) << n;
  }
  EXPECT_GT(tried, 60);
}

// Upright and rigid, without friction: a sharp bore takes it from within c + rho.
TEST(ContactDepth, ARoundedRimFindsASharpBoreFromWithinClearanceAndRadius) {
  for (const double edge : {0.2, 1.0, 5.0})
    for (const double part : {0.5, 0.97, 1.03, 1.5, 4.0}) {
      const World world = rounded(edge, {"holder.tilt_stiffness_N_m_rad=1e6"}).world;
      const double offset = part * (world.annulus.clearance() + 1e-6 * edge);
      State state = at_rest(world, testing::pose(1e-6, offset, 0));
      for (int n = 1; n <= 2000; ++n)
        state =
            step(world, state, testing::pose(1e-6 - n * (2.5e-9 + 2e-9 * edge), offset, 0), 1e-3)
                .state;
      EXPECT_EQ(state.tip[0] < -1e-6 - 1e-6 * edge, part < 1) << edge << " " << part;
    }
}

// The work of the hand over one round of a tilted end that circles on the face around the bore, in
// so many steps, pressed harder on one half of its way.
HandWork round_on_the_face(const World& world, int steps, double way) {
  const auto hand = [&](int n) {
    const double angle = 2 * std::numbers::pi * way * n / steps;
    return testing::pose((-2 - std::sin(angle)) * 1e-6, 20e-6 * std::cos(angle),
                         20e-6 * std::sin(angle), 0.02, 0);
  };
  StepResult now(at_rest(world, hand(0) + testing::pose(5e-6, 0, 0)));
  State& state = now.state;
  for (int n = 0; n <= steps; ++n)  // the first time round it settles
    step_on(world, hand(n), 1e-3, now);
  HandWork work(world, state);
  for (int n = 1; n <= steps; ++n) {
    work.move(state, hand(n));
    step_on(world, hand(n), 1e-3, now);
  }
  return work;
}

// Nothing rubs: what the hand loses is what an implicit step damps, and as short as the step.
TEST(ContactDepth, OnTheFaceAClosedMotionCostsNoEnergy) {
  const World world = testing::bare().world;
  for (const double way : {1.0, -1.0}) {
    const HandWork coarse = round_on_the_face(world, 500, way);
    const HandWork fine = round_on_the_face(world, 4000, way);
    EXPECT_GE(fine.work(), -1e-9 * fine.turned());
    EXPECT_LT(fine.work(), 0.13 * coarse.work());
  }
}

TEST(ContactDepth, OnTheFaceHasItsDerivatives) {
  const World world = testing::bare().world;
  RandomStream random(15, 0, Draw::start);
  int on_face = 0;
  for (int n = 0; n < 100; ++n) {
    State state;
    state.side = EdgeSide::face;
    state.tip << -1e-7, 3e-6 * random.normal() + 5e-6, 3e-6 * random.normal(),
        0.01 * random.normal(), 0.01 * random.normal();
    const bool over_the_opening = PoseVector(state.tip).e.norm() < world.annulus.clearance() + 1e-7;
    if (over_the_opening || contact_side(world, state.tip, state.side).side != EdgeSide::face)
      continue;
    ++on_face;
    const auto at = [&](const Pose& tip) {
      return contact_depths(world, contact_side(world, tip, state.side), tip)[kEnd];
    };
    const auto slope = [&](const Pose& tip) { return at(tip).by_pose(PoseVector(tip).t).full(); };
    Energy energy;
    at(state.tip).add_to(energy, PoseVector(state.tip).t, 1, 0);
    const Matrix5 hessian = energy.hessian.full();
    for (int i = 0; i < 5; ++i) {
      Pose by = Pose::Zero();
      by[i] = i < 3 ? 1e-11 : 1e-7;
      const double h = 2 * by[i];
      const double scale = i < 3 ? 1 : world.annulus.fibre_radius;
      EXPECT_NEAR((at(state.tip + by).value - at(state.tip - by).value) / h, slope(state.tip)[i],
                  1e-5 * scale);
      const Pose bend = (slope(state.tip + by) - slope(state.tip - by)) / h;
      for (int j = 0; j < 5; ++j) {
        const double unit = scale * (j < 3 ? 1 : world.annulus.fibre_radius) / 1e-6;
        EXPECT_NEAR(bend[j], hessian(j, i), 1e-4 * unit) << i << " " << j;
      }
    }
  }
  EXPECT_GT(on_face, 50);
}

// Over the mouth's edge, beyond where its rim goes round that, an upright end is as high as on the
// face, which is taken to fall off by 1e-4 there; where the lead-in is shorter than the rim, too.
TEST(ContactDepth, OverTheMouthsEdgeAnEndIsAsHighAsOnTheFace) {
  constexpr const char* kShort = "ferrule.lead_in={\"angle_deg\":60,\"diameter_um\":126.1}";
  const std::string no_lead_in = "ferrule.lead_in=null", rounded = "fibre.edge_um=0.5";
  for (const std::string& lead_in : {no_lead_in, std::string(kCone), std::string(kShort)})
    for (const bool sharp : {true, false}) {
      const World world = testing::bare({lead_in, sharp ? lead_in : rounded}).world;
      const double room = world.profile.mouth_radius() - world.annulus.fibre_radius;
      for (const double beyond : {0.1e-6, 1e-6, 5e-6}) {
        const PoseVector tip{testing::pose(world.profile.lead_in_length - 5e-9,
                                           room + world.end.rounding() + beyond, 0)};
        ContactSide side;
        for (const EdgeSide at : {EdgeSide::throat, EdgeSide::face}) {
          side.side = at;
          const double depth = contact_depths(world, side, tip)[kEnd].value;
          EXPECT_NEAR(depth, 5e-9, 0.3e-9 + 1e-4 * beyond) << lead_in << sharp;
        }
      }
    }
}

TEST(ContactDepth, WithARoundedRimNoClosedMotionGainsEnergy) {
  for (std::uint64_t k = 0; k < 30; ++k) {
    RandomStream random(13, k, Draw::start);
    std::vector<std::string> more = {"fibre.cleave_deg=" + std::to_string(random.uniform())};
    if (k % 2) more.emplace_back(kCone);
    const World world = rounded(std::pow(10.0, 1.3 * random.uniform() - 0.7), more).world;
    SCOPED_TRACE(k);
    testing::expect_no_energy_gained(world,
                                     testing::pose(world.profile.lead_in_length + 5e-6, 3e-6, 0),
                                     {150, 360, 400, 2e-7, 0.5e-6, 2e-4}, random);
  }
}

// Adhesion and wall know how sharp the edge is: pull-off falls with the root of its radius.
TEST(ContactDepth, TheContactRadiusFollowsFromTheEdge) {
  const auto radius = [](const std::vector<std::string>& settings) {
    return std::get<Adhesion>(load_scene("bench", settings).world.laws.adhesion).radius;
  };
  EXPECT_CLOSE(radius({}), 62.5e-6, 1e-12);
  EXPECT_CLOSE(radius({"fibre.edge_um=1"}), std::sqrt(62.5) * 1e-6, 1e-12);
  EXPECT_CLOSE(radius({"fibre.edge_um=1", "laws.adhesion.radius_um=3"}), 3e-6, 1e-12);
  EXPECT_CLOSE(rounded(4).world.laws.wall->radius, std::sqrt(4 * 62.5) * 1e-6, 1e-12);
}

}  // namespace
}  // namespace ferrule
