#include "sim/laws/friction.hpp"

#include "sim/laws/adhesion.hpp"
#include "sim/laws/paper/adhesion.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr Friction kFriction = {3.17e9, 0.73e9, 0.48e-9};

TEST(Friction, ConstantsAt20Digits) {
  EXPECT_CLOSE(hurtado_kim_m(), -0.42348600603698873, 1e-14);
  EXPECT_CLOSE(hurtado_kim_b(), -0.97947998282311279, 1e-14);
  EXPECT_CLOSE(kFriction.effective_shear_modulus(), 1186717948.7179487, 1e-15);
}

TEST(Friction, PrintedHasThePublishedValuesOfTableI) {
  EXPECT_CLOSE(friction(kFriction, printed::contact_radius(0)), 0.1296897463e-6, 4e-10);
  EXPECT_CLOSE(friction(kFriction, printed::contact_radius(10e-9)), 0.1728765087e-6, 4e-10);
}

TEST(Friction, Has30DigitValuesInAllThreeRanges) {
  EXPECT_CLOSE(friction(kFriction, 10e-9), 2.3734358974358974e-9, 1e-13);
  EXPECT_CLOSE(friction(kFriction, 1e-6), 4.8912474530919360e-6, 1e-13);
  EXPECT_CLOSE(friction(kFriction, 1e-4), 9.4937435897435897e-3, 1e-13);
}

TEST(Friction, IsContinuousAtBothKnees) {
  for (const double knee : {50 * 0.48e-9, 1e5 * 0.48e-9})
    EXPECT_CLOSE(friction(kFriction, knee * (1 - 1e-12)), friction(kFriction, knee * (1 + 1e-12)),
                 1e-11);
}

}  // namespace
}  // namespace ferrule
