#include "sim/laws/gravity.hpp"

#include "sim/laws/paper/gravity.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr FibreMass kFibre = {62.5e-6, 2330, 0.05};

TEST(Gravity, PrintedIsTheMassThatThePaperTakesAsNewtons) {
  EXPECT_CLOSE(printed::gravity({}, kFibre), 1.4297e-6, 5e-5);
}

TEST(Gravity, CorrectedIsTheWeight) {
  EXPECT_CLOSE(gravity(Gravity{}, kFibre), 1.4020e-5, 5e-5);
  EXPECT_CLOSE(gravity(Gravity{}, kFibre), 9.80665 * printed::gravity({}, kFibre), 1e-15);
}

}  // namespace
}  // namespace ferrule
