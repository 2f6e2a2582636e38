#include "sim/laws/flow.hpp"

#include <numbers>

#include "sim/analysis/gap_forces.hpp"
#include "sim/base/random.hpp"
#include "sim/scene/draw.hpp"
#include "sim/scene/terms.hpp"
#include "sim/solver/step.hpp"
#include "tests/compare.hpp"
#include "tests/scenes.hpp"
#include "tests/sim/laws/annulus.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;

constexpr double kBore = 10.5e-3;

double steady(const Flow& law, double length, double speed) {
  const double area = flow_area(kAnnulus);
  return area * area * speed * flow_resistance(law, kAnnulus, kBore, length, 0);
}

// Without the share that the side drags along: 0.900 MPa and 11.0 mN, 0.76 uN, 162 Pa and 2.0 uN.
// With it the area is larger by c/r, once for the pressure and once more for the force.
TEST(Flow, IsAsStrongAsPublishedFormulasSay) {
  const double speed = 30e-6, length = 100e-6, share = 1 + 0.5 / 62.5;
  const Flow epoxy = {0.1, true, false, 0}, open = {0.1, false, false, 0};
  const Flow air = {1.8e-5, true, true, 0};
  EXPECT_CLOSE(steady(epoxy, length, speed), 11.044e-3 * share * share, 1e-3);
  EXPECT_CLOSE(steady(epoxy, length, speed) / flow_area(kAnnulus), 0.900e6 * share, 1e-3);
  EXPECT_CLOSE(steady(open, length, speed), 0.76e-6 * share * share, 1e-2);
  EXPECT_CLOSE(steady(air, length, speed), 1.99e-6 * share * share, 1e-3);
}

// Stokes flow in the unrolled annulus, by finite differences across the gap at every angle: the
// wall moves, the pressure is what makes the net flow that of what the end displaces.
TEST(Flow, IsStokesFlowInTheEccentricAnnulus) {
  const double mu = 0.3, length = 80e-6, speed = 20e-6, r = kAnnulus.fibre_radius;
  const double c = kAnnulus.clearance();
  for (const double eps : {0.0, 0.4, 0.9}) {
    double flow[2] = {0, 0}, shear[2] = {0, 0};  // by 1 Pa between the ends; by the moving wall
    constexpr int kAngles = 400, kLayers = 400;
    for (int i = 0; i < kAngles; ++i) {
      const double h = c * (1 - eps * std::cos(2 * pi * (i + 0.5) / kAngles)), dy = h / kLayers;
      const double width = 2 * pi * r / kAngles;
      for (int wall = 0; wall < 2; ++wall) {
        // mu u'' = dp/ds, u = 0 at the bore, on the fibre the wall's speed: Thomas's algorithm.
        std::vector<double> above(kLayers + 1, 0), right(kLayers + 1, 0);
        const double source = wall ? 0 : dy * dy / (mu * length);
        right[0] = wall ? speed : 0;
        for (int n = 1; n < kLayers; ++n) {
          above[n] = 1 / (2 - above[n - 1]);
          right[n] = (right[n - 1] - source) * above[n];
        }
        std::vector<double> u(kLayers + 1, 0);
        for (int n = kLayers - 1; n >= 0; --n) u[n] = right[n] + above[n] * u[n + 1];
        double sum = 0.5 * u[0];
        for (int n = 1; n < kLayers; ++n) sum += u[n];
        flow[wall] += width * dy * sum;
        shear[wall] +=
            width * length * mu * (-3 * u[0] + 4 * u[1] - u[2]) / (2 * dy);  // on the fibre
      }
    }
    // Inwards: the pressure ahead drives it out (flow[0] is that of a pressure that falls inwards).
    const double pressure = (pi * r * r * speed + flow[1]) / -flow[0];
    const double out = pressure * pi * r * r + pressure * -shear[0];
    const Flow law = {mu, true, false, 0};
    const double area = flow_area(kAnnulus);
    const double resistance = flow_resistance(law, kAnnulus, kBore, length, eps * eps);
    EXPECT_CLOSE(pressure, area * speed * resistance, 1e-4) << eps;
    EXPECT_CLOSE(out, area * area * speed * resistance, 1e-4) << eps;
  }
}

TEST(Flow, AnOpenBoreTakesWhatTheAnnulusDoesNot) {
  const Flow blind = {1, true, false, 0}, open = {1, false, false, 0};
  const double R = kAnnulus.bore_radius;
  // Slow through the annulus: the tube alone. At the far end: nothing ahead.
  EXPECT_CLOSE(flow_resistance(open, kAnnulus, kBore, 1e-3, 0), 8 * 9.5e-3 / (pi * R * R * R * R),
               1e-4);
  EXPECT_EQ(flow_resistance(open, kAnnulus, kBore, kBore, 0), 0);
  const Annulus wide = {10e-6, 63e-6};
  EXPECT_CLOSE(flow_resistance(open, wide, kBore, 1e-6, 0),
               flow_resistance(blind, wide, kBore, 1e-6, 0), 1e-3);
}

// Energy, force and stiffness over a step belong together: of a liquid, where it cavitates, of a
// gas.
TEST(Flow, ForceAndStiffnessAreDerivativesOfTheEnergy) {
  const Flow laws[] = {{0.3, true, false, 2e3}, {0.3, false, false, 0}, {1.8e-5, true, true, 0}};
  for (const Flow& law : laws)
    for (const double dt : {1e-5, 1e-3, 0.1})
      for (const double before : {0.0, 30e-6, 2e-3}) {
        const FlowStep step(law, kAnnulus, kBore, before, 0.1, 2e-9, dt);
        ASSERT_TRUE(step.acts());
        EXPECT_EQ(step.at(before).energy, 0);
        for (const double now : {before + 3e-6, before + 4e-8, before * 0.999, before * 0.5}) {
          if (now == 0 || now == before) continue;
          const AxialForce f = step.at(now);
          const double h = 1e-3 * std::abs(now - before);
          const double force =
              testing::derivative([&](double l) { return step.at(l).energy; }, now, h);
          const double stiffness =
              testing::derivative([&](double l) { return step.at(l).force; }, now, h);
          EXPECT_LE(std::abs(f.force - force), 1e-7 * std::abs(force) + 2e-15)
              << dt << " " << before << " " << now;
          EXPECT_LE(std::abs(f.stiffness - stiffness), 1e-6 * std::abs(f.stiffness) + 1e-6)
              << dt << " " << before << " " << now;
        }
      }
}

TEST(Flow, ALiquidPullsNoHarderThanItCavitates) {
  const double vapour = 2.3e3;
  const Flow law = {1, true, false, vapour};
  const FlowStep step(law, kAnnulus, kBore, 100e-6, 0, 0, 1e-3);
  EXPECT_CLOSE(step.at(50e-6).force, -flow_area(kAnnulus) * (101325 - vapour), 1e-12);
  EXPECT_EQ(step.at(50e-6).stiffness, 0);
  EXPECT_GT(step.at(100.1e-6).force, 1e-3);
}

TEST(Flow, AGasThatCannotLeakObeysBoyle) {
  const Flow law = {1e6, true, true, 0};
  const FlowStep step(law, kAnnulus, 1e-3, 100e-6, 0, 0, 1e-3);
  const double pressure = kAtmosphere * 0.9e-3 / 0.4e-3;
  EXPECT_CLOSE(step.at(600e-6).force, flow_area(kAnnulus) * (pressure - kAtmosphere), 1e-9);
  EXPECT_CLOSE(step.air_at(600e-6), (pressure - kAtmosphere) * flow_area(kAnnulus) * 0.4e-3, 1e-9);
  // Isothermal work.
  const double volume = flow_area(kAnnulus) * 0.9e-3;
  EXPECT_CLOSE(step.at(600e-6).energy,
               kAtmosphere * (volume * std::log(0.9 / 0.4) - flow_area(kAnnulus) * 0.5e-3), 1e-9);
}

std::string flow_setting(const char* bore, const char* fluid, double viscosity) {
  return std::string("laws.flow={\"form\":\"corrected\",\"bore\":\"") + bore + "\",\"fluid\":\"" +
         fluid + "\",\"viscosity_Pa_s\":" + std::to_string(viscosity) +
         (std::string(fluid) == "liquid" ? ",\"vapour_pressure_kPa\":0}" : "}");
}

// A hand at constant speed, the fibre on its spring, on the axis: x of the end over time.
// The reference is Runge and Kutta's on the equations of the header, with steps far finer.
struct OnTheAxis {
  const World& world;
  double from, speed;  // of the command, inwards
  double stiffness = world.holder.stiffness(0, 0);

  template <class Rate, class State>
  static void advance(const Rate& rate, State& y, double t, double dt) {
    const State a = rate(t, y), b = rate(t + dt / 2, State(y + dt / 2 * a));
    const State c = rate(t + dt / 2, State(y + dt / 2 * b)), d = rate(t + dt, State(y + dt * c));
    y += dt / 6 * (a + 2 * b + 2 * c + d);
  }
};

TEST(Flow, HoldsBackAFibreInALiquidAsTheEquationSays) {
  for (const char* bore : {"open", "blind"}) {
    const Scene scene =
        testing::bare({flow_setting(bore, "liquid", bore[0] == 'o' ? 30.0 : 0.001)});
    const World& world = scene.world;
    const OnTheAxis on{world, -100e-6, 20e-6};
    const double area = flow_area(world.annulus), duration = 1.0;
    double lag = 0;
    for (const double dt : {2e-3, 1e-3}) {
      StepResult r(at_rest(world, testing::pose(on.from, 0, 0)));
      const State& state = r.state;
      for (double t = dt; t < duration + dt / 2; t += dt) {
        step_on(world, testing::pose(on.from - on.speed * t, 0, 0), dt, r);
        ASSERT_EQ(r.status, StepStatus::ok);
      }
      double x = on.from;
      const auto rate = [&](double t, double at) {
        const double hand = on.from - on.speed * t;
        return on.stiffness * (hand - at) /
               (area * area *
                flow_resistance(*world.laws.flow, world.annulus, world.profile.length, -at, 0));
      };
      for (int n = 0; n < 20000; ++n)
        OnTheAxis::advance(rate, x, n * duration / 20000, duration / 20000);
      EXPECT_CLOSE(state.tip[0], x, 1e-4) << bore;
      const double miss = std::abs(state.tip[0] - x) / (on.speed * dt);
      EXPECT_LT(miss, 0.5) << bore;
      const double error = std::abs(state.tip[0] - x);
      EXPECT_TRUE(lag == 0 || error < 0.7 * lag) << bore << ": of first order";
      lag = error;
      EXPECT_CLOSE(forces(world, r).force(Term::flow).x(), r.holder[0], 1e-6);
      EXPECT_GT(r.holder[0], 1e-7);
    }
  }
}

TEST(Flow, AGasIsACushionThatLeaks) {
  const Scene scene =
      testing::bare({flow_setting("blind", "gas", 1.8e-5), "holder.stiffness_N_m=5"});
  const World& world = scene.world;
  const OnTheAxis on{world, -100e-6, 30e-6};
  const double area = flow_area(world.annulus), length = world.profile.length, dt = 1e-3;
  const double moving = 2, duration = 6;
  const auto hand = [&](double t) { return on.from - on.speed * std::min(t, moving); };
  // The end where the spring holds the pressure of that amount of gas.
  const auto end_at = [&](double t, double amount) {
    double x = hand(t);
    for (int n = 0; n < 30; ++n) {
      const double volume = area * (length + x), over = amount / volume - kAtmosphere;
      x -= (on.stiffness * (hand(t) - x) + area * over) /
           (-on.stiffness - area * area * amount / (volume * volume));
    }
    return x;
  };
  const auto rate = [&](double t, double amount) {
    const double x = end_at(t, amount), pressure = amount / (area * (length + x));
    return (kAtmosphere * kAtmosphere - pressure * pressure) /
           (2 * annulus_resistance(*world.laws.flow, world.annulus, -x, 0));
  };
  double amount = kAtmosphere * area * (length + on.from), largest = 0;
  StepResult r(at_rest(world, testing::pose(on.from, 0, 0)));
  for (int n = 1; n <= std::lround(duration / dt); ++n) {
    OnTheAxis::advance(rate, amount, (n - 1) * dt, dt);
    step_on(world, testing::pose(hand(n * dt), 0, 0), dt, r);
    const double over = amount / (area * (length + end_at(n * dt, amount))) - kAtmosphere;
    largest = std::max(largest, area * over);
    ASSERT_LE(std::abs(forces(world, r).force(Term::flow).x() - area * over),
              2e-3 * largest + 1e-12)
        << n;
  }
  // Less than an incompressible gas, and gone after some time at rest.
  EXPECT_GT(largest, 0.3e-6);
  EXPECT_LT(largest, steady(*world.laws.flow, 160e-6, on.speed));
  EXPECT_LT(r.state.air, 0.02 * largest / area * area * length);
}

TEST(Flow, IsGoneOutsideAndAStateCarriesIt) {
  const Scene scene = testing::bare({flow_setting("blind", "gas", 1e-3)});
  StepResult now(at_rest(scene.world, testing::pose(-50e-6, 0, 0)));
  State& state = now.state;
  step_on(scene.world, testing::pose(-60e-6, 0, 0), 1e-3, now);
  EXPECT_GT(state.air, 0);
  EXPECT_EQ(state_of(to_row(state)).air, state.air);
  const StepResult on = step(scene.world, state, state.command, 1e-3);
  const StepResult again = step(scene.world, state_of(to_row(state)), state.command, 1e-3);
  EXPECT_CLOSE(again.holder[0], on.holder[0], 1e-9);
  for (int n = 1; n <= 100; ++n)
    step_on(scene.world, testing::pose(-60e-6 + n * 1e-6, 0, 0), 1e-3, now);
  EXPECT_EQ(state.air, 0);
}

// A hand that wanders anywhere and comes back has done work, or none.
TEST(Flow, NoClosedMotionGainsEnergy) {
  for (std::uint64_t k = 0; k < 40; ++k) {
    RandomStream random(3, k, Draw::start);
    const bool blind = random.uniform() < 0.7, gas = random.uniform() < 0.6;
    Scene scene =
        testing::bare({flow_setting(blind ? "blind" : "open", gas ? "gas" : "liquid",
                                    std::pow(10.0, (gas ? -6 : -4) + 4 * random.uniform())),
                       "ferrule.length_mm=" + std::to_string(0.25 + random.uniform())});
    State state = at_rest(scene.world, testing::pose(20e-6, 0, 0));
    const double dt = std::pow(10.0, -4 + 2 * random.uniform());
    double work = 0, turned = 0;
    double x = 20e-6;
    const Pose start = state.command;
    for (int n = 0; n < 300; ++n) {
      x = n == 299 ? 20e-6 : std::clamp(x + 20e-6 * random.normal() - 2e-6, -150e-6, 20e-6);
      Pose hand = start;
      hand[0] += x - 20e-6;
      const double more = -scene.world.holder.stiffness(0, 0) *
                          (state.tip[0] - 0.5 * (state.command[0] + hand[0])) *
                          (hand[0] - state.command[0]);
      work += more;
      turned += std::abs(more);
      const StepResult r = step(scene.world, state, hand, dt);
      ASSERT_LE(r.evaluations, SolverParameters{}.max_evaluations * 1);
      state = r.state;
    }
    EXPECT_GE(work, -1e-9 * turned) << k;
  }
}

TEST(Flow, ATermThatTheTableKnows) {
  const Scene scene = testing::bare({flow_setting("blind", "liquid", 0.1)});
  EXPECT_CLOSE(gap_forces(scene.world, {500e-9, 100e-6, {}, 0, 30e-6})[Term::flow],
               steady(*scene.world.laws.flow, 100e-6, 30e-6), 1e-9);
  for (const char* bad : {"laws.flow.bore=\"shut\"", "laws.flow.fluid=\"sand\"",
                          "laws.flow.viscosity_Pa_s=0", "laws.flow.vapour_pressure_kPa=102"})
    EXPECT_THROW(testing::bare({flow_setting("blind", "liquid", 0.1), bad}), BadInput) << bad;
  EXPECT_THROW(
      testing::bare({flow_setting("blind", "gas", 0.1), "laws.flow.vapour_pressure_kPa=1"}),
      BadInput);
}

}  // namespace
}  // namespace ferrule
