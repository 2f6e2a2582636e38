#include "sim/analysis/gap_forces.hpp"

#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

World corrected(const std::vector<std::string>& more = {}) {
  std::vector<std::string> settings = {"laws.van_der_waals.form=corrected",
                                       "laws.electrostatic.form=corrected", "laws.capillary=null",
                                       "roughness_nm=5"};
  settings.insert(settings.end(), more.begin(), more.end());
  return testing::paper(settings).world;
}

TEST(GapForces, OfParallelAxesAreTheLawTimesTheLength) {
  for (const World& world : {testing::paper().world, corrected()}) {
    const GapForces f = gap_forces(world, {20e-9, 100e-6, std::nullopt});
    const auto line = [&](const auto& law) { return van_der_waals(law, world.annulus, 20e-9); };
    const auto* as_printed = std::get_if<printed::VanDerWaals>(&world.laws.van_der_waals);
    EXPECT_EQ(f[Term::van_der_waals],
              100e-6 * (as_printed ? line(*as_printed)
                                   : line(std::get<VanDerWaals>(world.laws.van_der_waals)))
                           .force);
    EXPECT_LT(f[Term::gravity], 0);
    EXPECT_EQ(f[Term::adhesion], 0);
    EXPECT_EQ(f[Term::friction], 0);
  }
}

// From 5 nm at one end to 305 nm at the other, and past the bore's axis to the opposite wall.
TEST(GapForces, OfTiltedAxesAreTheMeanAlongTheFibre) {
  const World world = corrected();
  const double length = 300e-6, from = 5e-9;
  for (const double tilt : {1e-3, 3e-3}) {
    constexpr int kPieces = 200000;
    double mean = 0;
    for (int i = 0; i < kPieces; ++i) {
      const double h = from + length * tilt * (i + 0.5) / kPieces, c = world.annulus.clearance();
      mean +=
          (h > c ? -van_der_waals(std::get<VanDerWaals>(world.laws.van_der_waals), world.annulus,
                                  2 * c - h)
                        .force
                 : van_der_waals(std::get<VanDerWaals>(world.laws.van_der_waals), world.annulus, h)
                       .force) /
          kPieces;
    }
    const GapForces f = gap_forces(world, {from, length, std::nullopt, tilt, 0});
    EXPECT_CLOSE(f[Term::van_der_waals], length * mean, 1e-6) << tilt;
  }
}

TEST(GapForces, InContactAreThoseOfThePenetrationAndNothingIsOfWhatIsLeftOut) {
  const World world = testing::paper().world;
  const GapForces f = gap_forces(world, {0, 100e-6, 5e-9});
  EXPECT_EQ(f[Term::adhesion], adhesion_force(world.laws, 5e-9, 0).force);
  EXPECT_EQ(f[Term::friction],
            friction(*friction_law(world.laws), friction_radius(world, 5e-9, 0).value));
  const GapForces none = gap_forces(testing::bare().world, {1e-9, 100e-6, std::nullopt});
  for (const Term term : kAllTerms) EXPECT_EQ(none[term], 0);
  EXPECT_EQ(none.squeeze, 0);
}

}  // namespace
}  // namespace ferrule
