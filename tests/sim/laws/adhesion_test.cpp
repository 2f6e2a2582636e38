#include "sim/laws/adhesion.hpp"

#include "sim/laws/paper/adhesion.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

const double kModulus = reduced_modulus(4.7e10, 0.35, 7.0e10, 0.35);
const printed::Adhesion kPrinted = prepare(printed::Adhesion{0.144, 4.0, 1.05, kModulus, 62.5e-6});

TEST(ReducedModulus, OfTableI) {
  EXPECT_CLOSE(kModulus, 4.2726925917809e10, 1e-13);
}

TEST(ReducedModulus, OfSilicaOnZirconiaAt30Digits) {
  EXPECT_CLOSE(reduced_modulus(72e9, 0.17, 210e9, 0.3), 74818798223.053542, 1e-14);
}

TEST(Adhesion, PrintedHasThePublishedValuesOfTableI) {
  EXPECT_CLOSE(adhesion(kPrinted, 0).force, -5.574418828e-6, 2e-10);
  EXPECT_CLOSE(adhesion(kPrinted, 10e-9).force, -7.830277437e-6, 2e-10);
}

TEST(Adhesion, PrintedHas30DigitValuesOfOtherParameters) {
  const printed::Adhesion law =
      prepare(printed::Adhesion{0.09, 2.5, 1.2, 74818798223.053542, 62.5e-6});
  EXPECT_CLOSE(adhesion(law, 0).force, -9.8644216337964975e-6, 1e-13);
  EXPECT_CLOSE(adhesion(law, 4e-9).force, -1.1394157526463601e-5, 1e-13);
  EXPECT_CLOSE(adhesion(law, 10e-9).force, -1.3860002130455125e-5, 1e-13);
}

TEST(Adhesion, IsContinuousFromApproachToDepthAndHeldBeyondTenNanometres) {
  EXPECT_EQ(adhesion(kPrinted, -0.2e-9).force, 0);
  for (const double end : {-0.1e-9, 0.0, 10e-9}) {
    const ContactForce below = adhesion(kPrinted, end - 1e-18);
    const ContactForce above = adhesion(kPrinted, end + 1e-18);
    EXPECT_LT(std::abs(above.force - below.force), 1e-13);
    EXPECT_LT(std::abs(above.potential - below.potential), 1e-22);
  }
  EXPECT_EQ(adhesion(kPrinted, 20e-9).force, adhesion(kPrinted, 10e-9).force);
}

TEST(Adhesion, ForceAndSlopeAreDerivatives) {
  const auto at = [](double d) { return adhesion(kPrinted, d); };
  for (const double d : {-0.05e-9, 0.5e-9, 3e-9, 9e-9, 15e-9}) {
    EXPECT_CLOSE(at(d).force,
                 testing::derivative([&](double x) { return at(x).potential; }, d, 1e-11), 1e-8);
    const double slope = testing::derivative([&](double x) { return at(x).force; }, d, 1e-11);
    if (d < 10e-9) {
      EXPECT_CLOSE(at(d).slope, slope, 1e-8);
    } else {
      EXPECT_EQ(at(d).slope, 0);
    }
  }
}

Adhesion corrected() {
  return prepare(Adhesion{0.144, 4.0, kModulus, 62.5e-6});
}

// Fig. 7 of the paper: attractive at first, then quickly and increasingly repulsive.
TEST(Adhesion, CorrectedAttractsAndThenPushesBack) {
  const Adhesion law = corrected();
  EXPECT_LT(adhesion(law, 0, 1).force, 0);
  EXPECT_GT(adhesion(law, 5e-9, 1).force, 0);
  double before = adhesion(law, 3e-9, 1).force;
  for (double d = 4e-9; d < 50e-9; d += 1e-9) {
    EXPECT_GT(adhesion(law, d, 1).force, before);
    before = adhesion(law, d, 1).force;
  }
}

TEST(Adhesion, CorrectedTendsToHertzFarIn) {
  const Adhesion law = corrected();
  const double d = 3e-6;
  EXPECT_CLOSE(adhesion(law, d, 1).force, kModulus * std::sqrt(62.5e-6) * std::pow(d, 1.5), 2e-2);
}

TEST(Adhesion, CorrectedForceAndSlopeAreDerivatives) {
  const Adhesion law = corrected();
  const auto at = [&](double d) { return adhesion(law, d, 1); };
  for (const double d : {-1.5e-9, -1e-9, 0.0, 2e-9, 10e-9, 100e-9, 400e-9}) {
    const double step = 1e-12 + 1e-4 * std::abs(d);
    EXPECT_CLOSE(at(d).force,
                 testing::derivative([&](double x) { return at(x).potential; }, d, step), 1e-6);
    EXPECT_CLOSE(at(d).slope, testing::derivative([&](double x) { return at(x).force; }, d, step),
                 1e-5);
  }
}

}  // namespace
}  // namespace ferrule
