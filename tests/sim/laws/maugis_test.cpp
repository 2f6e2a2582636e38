#include "sim/laws/maugis.hpp"

#include "sim/base/error.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

TEST(Maugis, HasThePublishedValuesAtLambda4) {
  const MaugisPoint one = maugis_at_radius(4, 1), two = maugis_at_radius(4, 2);
  EXPECT_CLOSE(one.m, 1.044223169, 1e-9);
  EXPECT_CLOSE(one.P, -1.476575195, 1e-9);
  EXPECT_CLOSE(one.D, -0.603569589, 1e-9);
  EXPECT_CLOSE(two.m, 1.021379139, 1e-9);
  EXPECT_CLOSE(two.P, 1.252730387, 1e-9);
  EXPECT_CLOSE(two.D, 1.782581218, 1e-9);
}

TEST(Maugis, Has30DigitValuesDownToMNearOne) {
  const auto expect = [](double lambda, double s, double A, double P, double D) {
    const MaugisPoint p = maugis_at_s(lambda, s);
    EXPECT_CLOSE(p.A, A, 1e-13) << lambda << " " << s;
    EXPECT_CLOSE(p.P, P, 1e-11) << lambda << " " << s;
    EXPECT_CLOSE(p.D, D, 1e-12) << lambda << " " << s;
  };
  expect(4, 0.3, 1.004175401640823257, -1.4788488800713593, -0.59831240536480851);
  expect(0.05, 1e-2, 5474.8356905049350, 164101741504.18234, 29973822.188136188);
  expect(100, 1e-4, 14781.507110020012, 3229650760174.8630, 218492755.35681071);
  expect(1, 1e-6, 1224244973.4539024, 1.8348686844265580e27, 1498775755027144485.7);
  expect(0.01, 30, 0.37616811460112875, -1.9494063317838823, -0.0089647953978835666);
}

TEST(Maugis, RadiusAndSAreInverse) {
  for (const double lambda : {0.01, 0.5, 4.0, 100.0})
    for (const double A : {0.01, 0.3, 1.0, 3.0, 50.0}) {
      const MaugisPoint p = maugis_at_radius(lambda, A);
      const MaugisPoint q = maugis_at_s(lambda, std::sqrt((p.m - 1) * (p.m + 1)));
      EXPECT_CLOSE(q.A, A, 1e-6);
    }
}

TEST(Maugis, TendsToDmtAsLambdaFalls) {
  EXPECT_CLOSE(MaugisCurve(0.01).pull_off_force(), -2, 2e-3);
  // DMT: P = A^3 - 2, D = A^2.
  const MaugisPoint p = maugis_at_radius(0.01, 2);
  EXPECT_CLOSE(p.P, 8 - 2, 2e-2);
  EXPECT_CLOSE(p.D, 4, 1e-1);
}

TEST(Maugis, TendsToJkrAsLambdaGrows) {
  EXPECT_CLOSE(MaugisCurve(100).pull_off_force(), -1.5, 1e-3);
  // JKR: P = A^3 - A sqrt(6 A), D = A^2 - (2/3) sqrt(6 A); it lets go at D = -(3/4)^(1/3).
  const MaugisPoint p = maugis_at_radius(100, 2);
  EXPECT_CLOSE(p.P, 8 - 2 * std::sqrt(12.0), 1e-3);
  EXPECT_CLOSE(p.D, 4 - 2.0 / 3 * std::sqrt(12.0), 1e-3);
  EXPECT_CLOSE(MaugisCurve(100).begins(1), -std::cbrt(0.75), 1e-3);
}

TEST(Maugis, TendsToHertzFarIn) {
  const MaugisPoint p = maugis_at_radius(4, 1000);
  EXPECT_CLOSE(p.P, 1e9, 1e-3);
  EXPECT_CLOSE(p.D, 1e6, 1e-3);
}

TEST(Maugis, BranchesMeetWhereTheSurfacesTouch) {
  for (const double lambda : {0.05, 0.5, 4.0}) {
    const MaugisPoint apart = maugis_apart(lambda, maugis_touching_disc(lambda));
    const MaugisPoint touching = maugis_at_s(lambda, 1e7);
    EXPECT_CLOSE(touching.P, apart.P, 1e-5);
    EXPECT_CLOSE(touching.D, apart.D, 1e-5);
  }
}

TEST(MaugisCurve, IsTheExactCurveForAnyLambda) {
  for (const double lambda :
       {0.01, 0.03, 0.12, 0.5, 0.85, 0.9, 0.93, 1.0, 1.3, 2.0, 4.0, 5.8, 20.0, 100.0}) {
    const MaugisCurve curve(lambda);
    const int last = curve.branches();
    int compared = 0;
    for (double log_s = std::log(1e3); log_s > std::log(1e-4); log_s -= 0.013) {
      const MaugisPoint p = maugis_at_s(lambda, std::exp(log_s));
      const MaugisPoint next = maugis_at_s(lambda, std::exp(log_s - 1e-5));
      if (next.D <= p.D || p.D < curve.begins(last) + 1e-7) continue;  // the unstable side
      const auto value = curve.at(p.D, last);
      EXPECT_LT(std::abs(value.P - p.P), 1e-8 * std::max(1.0, std::abs(p.P)))
          << lambda << " " << p.D;
      EXPECT_LT(std::abs(value.A - p.A), 1e-7 * std::max(1e-2, p.A)) << lambda << " " << p.D;
      ++compared;
    }
    EXPECT_GT(compared, 100);
  }
}

TEST(MaugisCurve, EnergyAndSlopeAreThoseOfTheForce) {
  for (const double lambda : {0.05, 0.9, 4.0, 100.0}) {
    const MaugisCurve curve(lambda);
    const int last = curve.branches();
    for (double D = curve.begins(last) + 0.05; D < 300; D += 0.5 + 0.1 * std::abs(D)) {
      const auto at = [&](double d) { return curve.at(d, last); };
      EXPECT_LT(
          std::abs(testing::derivative([&](double d) { return at(d).energy; }, D, 1e-3) - at(D).P),
          1e-6 * (1 + std::abs(at(D).P)));
      EXPECT_LT(
          std::abs(testing::derivative([&](double d) { return at(d).P; }, D, 1e-3) - at(D).slope),
          1e-5 * (1 + std::abs(at(D).slope)));
      EXPECT_LT(
          std::abs(testing::derivative([&](double d) { return at(d).A; }, D, 1e-3) - at(D).A_slope),
          1e-5 * (1 + std::abs(at(D).A_slope)));
    }
  }
}

// Deeper than the table reaches (D = 1e4) the equations are solved; no step between.
TEST(MaugisCurve, GoesOnBeyondItsTable) {
  for (const double lambda : {0.01, 0.3, 4.0, 100.0}) {
    const MaugisCurve curve(lambda);
    const int last = curve.branches();
    const auto at = [&](double d) { return curve.at(d, last); };
    for (double D = 9e3; D < 1e12; D *= 1.03) {
      const double step = 1e-4 * D;
      EXPECT_CLOSE(testing::derivative([&](double d) { return at(d).energy; }, D, step), at(D).P,
                   1e-8)
          << lambda << " " << D;
      EXPECT_CLOSE(testing::derivative([&](double d) { return at(d).P; }, D, step), at(D).slope,
                   1e-8)
          << lambda << " " << D;
    }
    for (const double D : {3e4, 1e7, 1e20}) {
      const MaugisPoint p = maugis_at_radius(lambda, at(D).A);
      EXPECT_CLOSE(p.D, D, 1e-10) << lambda;
      EXPECT_CLOSE(p.P, at(D).P, 1e-10) << lambda;
    }
  }
}

// Approach and retreat jump at different distances; the area between is the energy lost.
TEST(MaugisCurve, ALoopLosesTheAreaBetweenItsBranches) {
  const MaugisCurve curve(4);
  EXPECT_LT(curve.begins(1), curve.attaches());
  int branch = 0;
  double work = 0, before = 0;
  const double from = -2, to = 1, step = 1e-5;
  for (int way = 0; way < 2; ++way)
    for (double d = 0; d < to - from; d += step) {
      const auto value = curve.at(way == 0 ? from + d : to - d, branch);
      work += (way == 0 ? 1 : -1) * 0.5 * (before + value.P) * step;
      before = value.P;
      branch = value.branch;
    }
  EXPECT_EQ(branch, 0);
  const double lost =
      curve.at(curve.begins(1) + 1e-12, 1).energy - curve.at(curve.attaches(), 1).energy;
  EXPECT_GT(lost, 0.1);
  EXPECT_CLOSE(work, lost, 1e-3);
}

TEST(MaugisCurve, RefusesLambdaOutOfRange) {
  EXPECT_THROW(MaugisCurve(0.009), BadInput);
  EXPECT_THROW(MaugisCurve(101), BadInput);
  EXPECT_THROW(MaugisCurve{NAN}, BadInput);
}

}  // namespace
}  // namespace ferrule
