#include "sim/base/elementary.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <random>
#include <span>

namespace ferrule {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kLeast = std::numeric_limits<double>::denorm_min();

using Function = double (*)(double);
using Exact = long double (*)(long double);

// |value - exact| in units of the last place of a double near `exact`.
long double ulps(double value, long double exact) {
  const int exponent = exact == 0 ? -1074 : std::max(std::ilogb(exact) - 52, -1074);
  return std::abs(value - exact) / std::ldexp(1.0L, exponent);
}

// Values to 30 digits by mpmath 1.3 with mp.dps = 60, of the double x exactly.
struct Row {
  double x;
  const char* value;
};

constexpr Row kExp[] = {
    {-744.5, "4.65326968270512698256778388216e-324"},
    {-708.25, "2.57592486928376938275365326383e-308"},
    {-100.3, "2.7559000653565684697104424608e-44"},
    {-30.7, "4.64685804474697281910655490766e-14"},
    {-1.0, "3.67879441171442321595523770161e-1"},
    {-0.3465, "7.07158819287271339291220187508e-1"},
    {-1e-09, "9.99999999000000000499999937552e-1"},
    {3e-17, "1.00000000000000003"},
    {0.3466, "1.41425091185052867423049805107"},
    {0.5, "1.64872127070012814684865078781"},
    {1.0, "2.71828182845904523536028747135"},
    {2.302585, "9.99999907005958743809479159959"},
    {10.1, "2.43430094244083796976113234163e+4"},
    {88.7, "3.32598698025057903859532452336e+38"},
    {300.25, "2.49412486153492128610161431491e+130"},
    {709.5, "1.35498631931463283087663227405e+308"},
};
constexpr Row kExpm1[] = {
    {-40.0, "-9.99999999999999995751645744708e-1"},
    {-2.5, "-9.17915001376101204830471325533e-1"},
    {-0.7, "-5.03414696208590463242382388214e-1"},
    {-0.35, "-2.95311910281286549997960453272e-1"},
    {-0.0628, "-6.08687188360074667964978018232e-2"},
    {-1e-05, "-9.99995000016666706802319220777e-6"},
    {-3e-17, "-3.00000000000000001555287661289e-17"},
    {2e-300, "2.00000000000000005011818367042e-300"},
    {1e-09, "1.00000000050000006244825818677e-9"},
    {0.02, "2.02013400267558105848880520273e-2"},
    {0.3465, "4.1410949383036241509832930219e-1"},
    {0.37, "4.47734614663324455155519124535e-1"},
    {0.9, "1.45960311115694971841428667252"},
    {5.5, "2.43691932264220387915188949512e+2"},
    {41.0, "6.39843493530054948222663403516e+17"},
    {650.0, "1.95619992137027188682156684983e+282"},
};
constexpr Row kLog[] = {
    {5e-324, "-7.44440071921381262314107298446e+2"},
    {3e-310, "-7.12702766539486055409249355425e+2"},
    {1e-200, "-4.60517018598809136821498028538e+2"},
    {2e-16, "-3.61482143073447856557728444295e+1"},
    {0.02, "-3.91202300542814603780206907619"},
    {0.49999, "-6.93167180759947996126077483343e-1"},
    {0.7, "-3.56674943938732442353954404107e-1"},
    {0.70711, "-3.46569038200694120288913828539e-1"},
    {0.99999999, "-1.00000001002475935891034265177e-8"},
    {1.0000000001, "1.00000008269037099081966940804e-10"},
    {1.3, "2.62364264467491086196204436886e-1"},
    {1.41421, "3.46571071298627375084044121814e-1"},
    {1.5, "4.05465108108164381978013115464e-1"},
    {2.0, "6.93147180559945309417232121458e-1"},
    {2000.0, "7.60090245954208236147120648551"},
    {1000000000000000.0, "3.45387763949106852602698718203e+1"},
    {1.7e+308, "7.09726836893228241037791026376e+2"},
};
constexpr Row kLog1p[] = {
    {-0.999999, "-1.38155105579355184395921509177e+1"},
    {-0.75, "-1.38629436111989061883446424292"},
    {-0.3, "-3.56674943938732363052309788025e-1"},
    {-0.0001, "-1.0000500033335834012615288196e-4"},
    {-1e-17, "-1.00000000000000007654242405462e-17"},
    {5e-324, "4.94065645841246544176568792868e-324"},
    {1e-16, "9.99999999999999929097786724035e-17"},
    {2e-09, "1.9999999980000001272298493291e-9"},
    {0.03, "2.95588022415444016547329740098e-2"},
    {0.41, "3.43589704390076892857584244309e-1"},
    {0.5, "4.05465108108164381978013115464e-1"},
    {1.0, "6.93147180559945309417232121458e-1"},
    {3.0, "1.38629436111989061883446424292"},
    {100000.0, "1.15129354649202287534207906268e+1"},
    {1e+17, "3.91439465808987766383058547296e+1"},
    {1e+300, "6.90775527898213705257902196661e+2"},
};
constexpr Row kCbrt[] = {
    {-1e+300, "-1.00000000000000001750158675173e+100"},
    {-27.0, "-3.0"},
    {-0.3, "-6.69432950082169513624660717707e-1"},
    {-5e-324, "-1.7031839360032602879640214865e-108"},
    {5e-324, "1.7031839360032602879640214865e-108"},
    {1e-310, "4.64158883361277416562139895388e-104"},
    {3e-21, "1.44224957030740836800994788834e-7"},
    {0.125, "5.0e-1"},
    {0.7, "8.87904001742600689652669595416e-1"},
    {1.0, "1.0"},
    {2.0, "1.25992104989487316476721060728"},
    {4.3, "1.62613333167916867309681218805"},
    {7.999, "1.99991666319420326997360399103"},
    {100000.0, "4.64158883361277889241007635092e+1"},
    {1.7e+308, "5.53965825675446414433171968109e+102"},
};
constexpr Row kSin[] = {
    {-1000000.0, "3.49993502171292952117652486781e-1"},
    {-4.5, "9.77530117665097055389135014499e-1"},
    {-0.8, "-7.17356090899522792567167815703e-1"},
    {-1e-09, "-1.00000000000000006211492479111e-9"},
    {5e-324, "4.94065645841246544176568792868e-324"},
    {0.5, "4.79425538604203000273287935216e-1"},
    {0.7853981, "7.07106736357780485182993557515e-1"},
    {0.79, "7.10353272417607834819637681743e-1"},
    {1.5707, "9.99999995360574296058266757186e-1"},
    {3.0, "1.41120008059867222100744802808e-1"},
    {3.141592653589793, "1.22464679914735317722606593227e-16"},
    {6.283185307179586, "-2.44929359829470635445213186455e-16"},
    {22.0, "-8.85130929040387592169025681577e-3"},
    {355.0, "-3.01443533594884492143302800087e-5"},
    {5678.9, "-8.90988482624295821951532415255e-1"},
    {123456.7, "-9.99304269883620416585301564618e-1"},
    {1000000.0, "-3.49993502171292952117652486781e-1"},
};
constexpr Row kCos[] = {
    {-1000000.0, "9.36752127533144786938532535075e-1"},
    {-4.5, "-2.10795799430779705980481824794e-1"},
    {-0.8, "6.96706709347165389063740022772e-1"},
    {0.0, "1.0"},
    {1e-09, "9.999999999999999995e-1"},
    {0.5, "8.77582561890372716116281582604e-1"},
    {0.7853981, "7.07106826015311721589343560712e-1"},
    {0.79, "7.03845315652236071675962984098e-1"},
    {1.5707963267948966, "6.12323399573676588613032966138e-17"},
    {3.0, "-9.89992496600445457271572794731e-1"},
    {4.71238898038469, "-1.83697019872102976583909889841e-16"},
    {11.0, "4.42569798805078574835502472394e-3"},
    {355.0, "-9.99999999545658980165935841693e-1"},
    {5678.9, "4.54025906563551615767920536429e-1"},
    {123456.7, "-3.72957932261043253536837398622e-2"},
    {1000000.0, "9.36752127533144786938532535075e-1"},
};
constexpr Row kTan[] = {
    {-1000000.0, "3.73624453987599029173497088575e-1"},
    {-1.2, "-2.57215162212631859719325219168"},
    {-1e-09, "-1.00000000000000006261492479111e-9"},
    {0.1, "1.00334672085450550665078502548e-1"},
    {0.5235987755982988, "5.7735026918962568795152992722e-1"},
    {0.7853981633974483, "9.99999999999999938767660042632e-1"},
    {0.9, "1.26015821755033919459969111271"},
    {1.5, "1.4101419947171719387646083652e+1"},
    {1.5707963267948966, "1.63312393531953697559677370415e+16"},
    {2.5, "-7.47022297238660279355352687825e-1"},
    {3.141592653589793, "-1.22464679914735317722606593228e-16"},
    {355.0, "3.01443533731842654681412311801e-5"},
    {1000000.0, "-3.73624453987599029173497088575e-1"},
};
constexpr Row kAtan[] = {
    {-1e+300, "-1.57079632679489661923132169164"},
    {-2.0, "-1.10714871779409050301706546018"},
    {-0.44, "-4.14506874584785940201723928555e-1"},
    {-1e-09, "-1.00000000000000006194825812445e-9"},
    {5e-324, "4.94065645841246544176568792868e-324"},
    {0.1, "9.96686524911620328745997071313e-2"},
    {0.1414, "1.40468764203968823459693085799e-1"},
    {0.4375, "4.12410441597387306899791289667e-1"},
    {0.5, "4.63647609000806116214256231461e-1"},
    {0.6875, "6.02287346134964181682122694204e-1"},
    {0.7, "6.1072596438920858673911392011e-1"},
    {1.0, "7.8539816339744830961566084582e-1"},
    {1.1875, "8.70903457075652953140173112598e-1"},
    {1.5, "9.82793723247329067985710611015e-1"},
    {2.4375, "1.18147960496175576230203803971"},
    {2.5, "1.19028994968253173292773377483"},
    {17.0, "1.51204050407917392632913838919"},
    {1000000000.0, "1.57079632579489661923132169197"},
    {1e+17, "1.57079632679489660923132169164"},
};

void expect_within(Function f, std::span<const Row> rows, double bound) {
  for (const Row& row : rows)
    EXPECT_LE(ulps(f(row.x), std::strtold(row.value, nullptr)), bound) << "at " << row.x;
}

TEST(Elementary, HasThe30DigitValues) {
  expect_within(elementary::exp, kExp, 1);
  expect_within(elementary::expm1, kExpm1, 2);
  expect_within(elementary::log, kLog, 1);
  expect_within(elementary::log1p, kLog1p, 2);
  expect_within(elementary::cbrt, kCbrt, 1);
  expect_within(elementary::sin, kSin, 1);
  expect_within(elementary::cos, kCos, 1);
  expect_within(elementary::tan, kTan, 3);
  expect_within(elementary::atan, kAtan, 1);
}

// The C library's functions of long doubles have 11 bits more.
void expect_within(Function f, Exact exact, double from, double to, double bound) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> x_of(from, to);
  for (int i = 0; i < 20000; ++i) {
    const double x = x_of(random);
    ASSERT_LE(ulps(f(x), exact(x)), bound) << "at " << x;
  }
}

TEST(Elementary, ErrorsAreWithinTheBoundsEverywhere) {
  if (std::numeric_limits<long double>::digits < 64) GTEST_SKIP() << "no longer double here";
  for (const double range : {1e-6, 0.5, 30.0, 709.0}) {
    expect_within(elementary::exp, std::exp, -range, range, 1);
    expect_within(elementary::expm1, std::expm1, -range, range, 2);
  }
  expect_within(elementary::log, std::log, 0.5, 2, 1);
  expect_within(elementary::log, std::log, 0, 1e5, 1);
  expect_within(elementary::log1p, std::log1p, -0.999, 1, 2);
  expect_within(elementary::log1p, std::log1p, -1e-6, 1e-6, 2);
  for (const double range : {8.0, 1e-310, 1e300})
    expect_within(elementary::cbrt, std::cbrt, -range, range, 1);
  for (const double range : {1e-3, 1.0, 10.0, 1e4, 1e6}) {
    expect_within(elementary::sin, std::sin, -range, range, 1);
    expect_within(elementary::cos, std::cos, -range, range, 1);
    expect_within(elementary::tan, std::tan, -range, range, 3);
    expect_within(elementary::atan, std::atan, -range, range, 1);
  }
}

TEST(Elementary, EndsOfTheRange) {
  EXPECT_EQ(elementary::exp(0), 1);
  EXPECT_EQ(elementary::exp(kInfinite), kInfinite);
  EXPECT_EQ(elementary::exp(709.79), kInfinite);
  EXPECT_LT(elementary::exp(709.78), kInfinite);
  EXPECT_EQ(elementary::exp(-kInfinite), 0);
  EXPECT_EQ(elementary::exp(-745.2), 0);
  EXPECT_EQ(elementary::exp(-745.1), kLeast);
  EXPECT_EQ(elementary::expm1(0), 0);
  EXPECT_EQ(elementary::expm1(-kInfinite), -1);
  EXPECT_EQ(elementary::expm1(kInfinite), kInfinite);
  EXPECT_EQ(elementary::log(1), 0);
  EXPECT_EQ(elementary::log(0), -kInfinite);
  EXPECT_EQ(elementary::log(-0.0), -kInfinite);
  EXPECT_EQ(elementary::log(kInfinite), kInfinite);
  EXPECT_TRUE(std::isnan(elementary::log(-kLeast)));
  EXPECT_EQ(elementary::log1p(-1), -kInfinite);
  EXPECT_EQ(elementary::log1p(0), 0);
  EXPECT_EQ(elementary::log1p(kInfinite), kInfinite);
  EXPECT_TRUE(std::isnan(elementary::log1p(-1.5)));
  EXPECT_EQ(elementary::cbrt(0), 0);
  EXPECT_EQ(elementary::cbrt(-27), -3);
  EXPECT_EQ(elementary::cbrt(-kInfinite), -kInfinite);
  EXPECT_EQ(elementary::sin(0), 0);
  EXPECT_EQ(elementary::cos(0), 1);
  EXPECT_EQ(elementary::tan(0), 0);
  EXPECT_EQ(elementary::atan(kInfinite), std::numbers::pi / 2);
  EXPECT_EQ(elementary::atan(-kInfinite), -std::numbers::pi / 2);
  for (const Function f : {elementary::sin, elementary::cos, elementary::tan}) {
    EXPECT_TRUE(std::isnan(f(kInfinite)));
    EXPECT_TRUE(std::isnan(f(-kInfinite)));
  }
  for (const Function f :
       {Function(elementary::exp), Function(elementary::expm1), Function(elementary::log),
        Function(elementary::log1p), Function(elementary::cbrt), Function(elementary::sin),
        Function(elementary::cos), Function(elementary::tan), Function(elementary::atan)})
    EXPECT_TRUE(std::isnan(f(std::numeric_limits<double>::quiet_NaN())));
}

// Of an angle beyond 1e6: sine and cosine of one that rounds to the same double.
TEST(Elementary, HugeAnglesAreOfTheUnitCircleAndNearlyThemselves) {
  for (const double x : {1.1e6, -3e7, 1e10, 1e100, 1.7e308}) {
    const double s = elementary::sin(x), c = elementary::cos(x);
    EXPECT_NEAR(s * s + c * c, 1, 1e-15) << x;
    if (std::abs(x) > 1e11) continue;
    EXPECT_NEAR(s, std::sin(x), std::abs(x) * 0x1p-53) << x;
    EXPECT_NEAR(c, std::cos(x), std::abs(x) * 0x1p-53) << x;
  }
}

struct Dual {
  double a, v;
};

TEST(Elementary, ExpOfADualNumberHasItsDerivative) {
  const Dual y = elementary::exp(Dual{0.3, 2.0});
  EXPECT_EQ(y.a, elementary::exp(0.3));
  EXPECT_EQ(y.v, 2.0 * elementary::exp(0.3));
}

}  // namespace
}  // namespace ferrule
