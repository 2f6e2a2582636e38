#include "sim/solver/friction_coupling.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "bench/random_scene.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/terms.hpp"
#include "sim/solver/newton.hpp"
#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

// In the bore, far from the mouth, where nothing is cut off a contact's patch.
TEST(FrictionCoupling, AreThoseOfTheContactsWhereAStepEnds) {
  const Scene scene = load_scene("bench");
  const World& world = scene.world;
  const Friction& law = *friction_law(world.laws);
  StepResult r(draw_start(scene, 1, 1));
  const State& state = r.state;
  int slipped = 0;
  for (const Pose& hand : commands(scene, state, Motion::press, 1e-3, 1, 1)) {
    const State before = state;
    step_on(world, hand, 1e-3, r);
    if (r.substeps != 1 || r.status != StepStatus::ok || state.tip[0] > -2e-6) continue;
    for (int place = 0; place < kContactPlaces; ++place) {
      const ContactState& contact = state.contact[place];
      if (!contact.closed || !before.contact[place].closed) continue;
      const double limit =
          friction(law, friction_radius(world, contact.depth, contact.branch).value);
      const double force = forces(world, r)[Term::friction][place].force.norm();
      EXPECT_LE(force, 1.005 * limit);
      slipped += force > 0.995 * limit;
    }
  }
  EXPECT_GT(slipped, 1000);
}

// Against differences, for each law that gives a contact its radius.
TEST(FrictionLimit, ByDepthIsItsDerivative) {
  for (const char* form :
       {"laws.adhesion.form=corrected", "laws.adhesion.form=printed", "laws.adhesion=null"})
    for (const char* friction : {"laws.friction.form=corrected", "laws.friction.form=printed"}) {
      const World world = load_scene("paper", {form, friction}).world;
      FrozenCoefficients frozen;
      FrozenFriction& contact = frozen.friction[kEnd];
      contact.acts = true;
      contact.patch = contact.share = 0.7;
      frozen.branch[kEnd] = 1;
      for (const double depth : {0.5e-9, 3e-9, 9e-9}) {
        const auto limit = [&](double d) {
          Potential there(world, frozen, PoseVector());
          there.depth[kEnd].value = d;
          there.pull[kEnd] = adhesion_force(world.laws, d, 1);
          return friction_limits(world, frozen, there)[kEnd];
        };
        const double h = 1e-3 * depth;
        EXPECT_CLOSE(limit(depth).per_depth,
                     (limit(depth + h).limit - limit(depth - h).limit) / (2 * h), 1e-5);
      }
    }
}

// Limits that miss by 3 %, moved once.
TEST(FrictionCoupling, SettleWhereLimitAndDepthAgree) {
  const Scene scene = load_scene("bench");
  const World& world = scene.world;
  StepResult now(draw_start(scene, 1, 1));
  State& state = now.state;
  int settled = 0;
  for (const Pose& hand : commands(scene, state, Motion::press, 1e-3, 1, 1)) {
    step_on(world, hand, 1e-3, now);
    if (!(state.contact[kEnd].closed && state.contact[kSide].closed && state.tip[0] < -2e-6))
      continue;
    FrozenCoefficients frozen = freeze(world, state, hand, 1e-3);
    const Potential there(world, frozen, state.tip);
    const FrictionCoupling before(world, frozen, state.tip, there);
    if (before.largest_error() != 0) continue;
    for (FrozenFriction& friction : frozen.friction) friction.limit *= 0.97;
    const FrictionCoupling missed(world, frozen, state.tip, there);
    if (!(missed.largest_error() > 0.02)) continue;  // nothing slips
    const NewtonStep newton(
        world, frozen,
        without_friction(world, frozen, state.tip, there.bore.gradient, there.bore.hessian),
        state.tip, 1);
    if (!newton.convex) continue;
    const PoseVector end =
        retract(world, frozen, state.tip, *CoupledModel(newton, missed).step(frozen));
    const FrictionCoupling after(world, frozen, end, Potential(world, frozen, end));
    EXPECT_LT(after.largest_error(), 0.5 * missed.largest_error());
    ++settled;
  }
  EXPECT_GT(settled, 50);
}

// A hand that trembles lets contacts stick and slide in turn. A last Newton step that is not
// evaluated leaves no more than what it may begin with.
TEST(FrictionCoupling, ForcesBalanceWhereContactsBeginAndStopToSlide) {
  for (const char* name : {"bench", "hard", "sticky", "laser"}) {
    const World world = load_scene(name).world;
    StepResult now(at_rest(world, testing::pose(2e-6, 0, 0)));
    const Pose first = now.state.command;
    const double tremor = 0.3e-6;
    int rubbing = 0;
    for (int n = 0; n < 12000; ++n) {
      const double t = 1e-3 * n, pressed = std::min(1.0, t), turn = 2 * std::numbers::pi * t;
      const Pose to =
          first + pressed * testing::pose(0, 1e-6, 0, 0, 3e-4) - testing::pose(8e-6 * t, 0, 0) +
          tremor * testing::pose(-std::sin(8 * turn), std::sin(7 * turn), std::cos(9 * turn));
      step_on(world, to, 1e-3, now);
      if (now.evaluations == 0 || now.status != StepStatus::ok) continue;
      const Breakdown all = forces(world, now);
      double scale = 0;
      for (const Term term : kAllTerms) scale += all.force(term).norm();
      const Wrench left = all.sum(now.state.tip) - now.holder;
      EXPECT_LT(left.head<3>().norm(), world.numerics.solver.final_residual * scale)
          << name << " " << n;
      rubbing += all.force(Term::friction).norm() > 0;
    }
    EXPECT_GT(rubbing, 5000) << name;
  }
}

}  // namespace
}  // namespace ferrule
