#include "controller/admittance_law.hpp"

#include "controller/law.hpp"
#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

// A case drawn by chance, in the hand's usual ranges.
struct Case : Observation {
  std::vector<double> gains;  // of the saturated law
};

Case draw(std::uint64_t seed) {
  RandomStream random(seed, 0, Draw::operator_hand);
  Case c{};
  for (int i = 0; i < kSaturatedGains; ++i) c.gains.push_back(6e-3 * (2 * random.uniform() - 1));
  c.gains[6] = 0.001 + 0.02 * random.uniform();
  c.gains[13] = 0.5 * random.uniform();
  c.gains[14] = 3 * random.uniform();
  for (int i = 0; i < 3; ++i) c.wrench[i] = 6 * random.uniform() - 3;
  c.depth = 0.02 * random.uniform();
  c.time = 15 * random.uniform();
  return c;
}

Eigen::Vector3d velocity(LawKind kind, const Case& c) {
  return law_velocity(kind, c.gains.data(), c);
}

void expect_same(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double tolerance) {
  EXPECT_LE((a - b).norm(), tolerance * b.norm()) << a.transpose() << " and " << b.transpose();
}

TEST(AdmittanceLaw, PhasedIsLinearWhereThePhasesAreTheSame) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    Case c = draw(seed);
    std::copy_n(c.gains.begin(), 6, c.gains.begin() + 7);
    expect_same(velocity(LawKind::phased, c), velocity(LawKind::linear, c), 1e-13);
  }
}

TEST(AdmittanceLaw, SaturatedIsPhasedWithoutDeadBandAndSaturation) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    Case c = draw(seed);
    c.gains[13] = c.gains[14] = 0;
    EXPECT_EQ(velocity(LawKind::saturated, c), velocity(LawKind::phased, c));
  }
}

TEST(AdmittanceLaw, PhasedIsTheOuterLawOutsideAndTheBoreLawDeepInside) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    Case c = draw(seed), bore = c;
    std::copy_n(c.gains.begin() + 7, 6, bore.gains.begin());
    c.depth = 0;
    EXPECT_EQ(velocity(LawKind::phased, c), velocity(LawKind::linear, c));
    c.depth = 40 * c.gains[6];
    expect_same(velocity(LawKind::phased, c), velocity(LawKind::linear, bore), 1e-13);
    // One length deep: 1 - 1/e of the way.
    c.depth = c.gains[6];
    const Eigen::Vector3d way = velocity(LawKind::phased, c) - velocity(LawKind::linear, c);
    expect_same(
        way, (1 - std::exp(-1)) * (velocity(LawKind::linear, bore) - velocity(LawKind::linear, c)),
        1e-10);
  }
}

TEST(AdmittanceLaw, InsertionIsLinearFarFromItsEndsWithoutSlowingAndLeaning) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    Case c = draw(seed);
    c.time += 1;
    const double v = std::abs(c.gains[0]);
    c.gains[0] = -v;
    const double insertion[] = {v,          1e-3,       1,          1e-3,       0, c.gains[3],
                                c.gains[4], c.gains[5], c.gains[1], c.gains[2], 0, 0};
    expect_same(law_velocity(LawKind::insertion, insertion, c), velocity(LawKind::linear, c),
                1e-12);
  }
}

TEST(AdmittanceLaw, GuardedIsTheInsertionLawOutsideAndYieldsOtherwiseInTheBore) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    Case c = draw(seed);
    c.gains[1] = c.gains[3] = 0.5;
    std::vector<double> bore = c.gains;
    std::copy_n(c.gains.begin() + kGains, 2, bore.begin() + 6);
    EXPECT_EQ(velocity(LawKind::guarded, c), law_velocity(LawKind::insertion, bore.data(), c));
    c.depth = 0;
    EXPECT_EQ(velocity(LawKind::guarded, c), velocity(LawKind::insertion, c));
  }
}

TEST(SaturatedForce, IsOddGrowsAndStaysBelowItsLimit) {
  for (std::uint64_t seed = 1; seed <= 500; ++seed) {
    RandomStream random(seed, 0, Draw::operator_hand);
    const double dead = random.uniform(), s = 0.1 + 5 * random.uniform();
    double before = 0;
    for (double f = 0.01; f < 1e4; f *= 1.3) {
      const double g = saturated_force(f, dead, s);
      EXPECT_EQ(saturated_force(-f, dead, s), -g);
      EXPECT_TRUE(f <= dead ? g == 0 : g > before) << f;
      EXPECT_LE(g, std::min(f, 1 / s));
      before = g;
    }
    EXPECT_CLOSE(before, 1 / s, 0.01);  // the limit is reached
    // It begins at the dead band's edge without a jump, as the force beyond it.
    EXPECT_CLOSE(saturated_force(dead + 1e-6, dead, s), 1e-6, 1e-4);
  }
}

TEST(Law, CommandsItsVelocityAndTiltsUnderMomentsWhereItHasTiltGains) {
  Case c = draw(1);
  c.wrench.tail<2>() << 0.1, 0.2;
  for (const LawKind kind : kLaws) {
    std::vector<double> gains(c.gains.begin(),
                              c.gains.begin() + static_cast<long>(gain_table(kind).size()));
    if (is_insertion_law(kind)) gains[1] = gains[3] = 0.5;
    Law law(kind, gains);
    const HandTwist v = law.command(c);
    EXPECT_EQ(Eigen::Vector3d(v.head<3>()), law_velocity(kind, gains.data(), c));
    EXPECT_EQ(v.tail<2>().norm(), 0);
    gains.insert(gains.end(), {3, 5});
    HandTwist tilting = v;
    tilting.tail<2>() << 3 * 0.1, 5 * 0.2;
    EXPECT_EQ(Law(kind, gains).command(c), tilting);
  }
}

}  // namespace
}  // namespace ferrule
