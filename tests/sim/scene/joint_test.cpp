#include "sim/scene/joint.hpp"

#include <complex>
#include <numbers>

#include "sim/base/random.hpp"
#include "tests/compare.hpp"

namespace ferrule {
namespace {

constexpr double kPi = std::numbers::pi;

double efficiency(double loss_dB) {
  return std::exp(-loss_dB / 4.343);
}

LightAxis light(double y, double z, double slope_y = 0, double slope_z = 0) {
  return {{y, z}, {slope_y, slope_z}};
}

// |<partner|light>|^2 where the partner begins, by the trapezoidal rule, which converges
// exponentially here. The light's field is the textbook's: width w(g) and wavefront of radius R(g)
// about where its axis has come to; and either field has the phase of a plane wave along its slope.
double overlap(const Joint& joint, const LightAxis& from, const LightAxis& into) {
  using Complex = std::complex<double>;
  const double k = 2 * kPi * joint.index / joint.wavelength, g = joint.gap;
  const double w1 = joint.mode_radius, w2 = joint.partner_mode_radius.value_or(w1);
  const double rayleigh = k * w1 * w1 / 2;
  const double w = w1 * std::sqrt(1 + g * g / (rayleigh * rayleigh));
  const double curvature = g / (g * g + rayleigh * rayleigh);  // 1/R
  const Vector2d centre = from.offset + g * from.slope;
  const double reach = 6 * w2;
  constexpr int kHalf = 300;
  const double h = reach / kHalf;
  Complex sum = 0;
  for (int i = -kHalf; i <= kHalf; ++i)
    for (int j = -kHalf; j <= kHalf; ++j) {
      const Vector2d r = into.offset + h * Vector2d(i, j), off = r - centre;
      const double out = std::exp(-off.squaredNorm() / (w * w));
      const double in = std::exp(-(r - into.offset).squaredNorm() / (w2 * w2));
      sum += out * in *
             std::polar(
                 1.0, k * off.squaredNorm() * curvature / 2 + k * (from.slope - into.slope).dot(r));
    }
  return std::norm(sum * h * h * 2.0 / (kPi * w * w2));
}

TEST(JointLoss, HasTheValueAt15Digits) {
  EXPECT_CLOSE(joint_loss_dB({}, light(0.5e-6, 0, 0, 5e-3)), 0.0661516783327908, 1e-13);
}

// To the last bit: what losses were before there was more to a joint.
TEST(JointLoss, OfEqualModesThatTouchIsThatOfOffsetAndTilt) {
  RandomStream random(1, 1, Draw::start);
  for (int i = 0; i < 1000; ++i) {
    const Vector2d offset = 2e-6 * Vector2d(random.normal(), random.normal());
    const Vector2d slope = 5e-3 * Vector2d(random.normal(), random.normal());
    const double d = offset.norm() / 5.2e-6;
    const double t = kPi * 1.4682 * 5.2e-6 * slope.norm() / 1550e-9;
    EXPECT_EQ(joint_loss_dB({}, {offset, slope}), 4.343 * (d * d + t * t));
  }
  EXPECT_EQ(joint_loss_dB({}, {}), 0);
}

TEST(JointLoss, IsTheOverlapOfTheFieldsWhateverActsAtOnce) {
  RandomStream random(2, 1, Draw::start);
  const auto pair = [&](double size) -> Vector2d {
    return size * Vector2d(random.normal(), random.normal());
  };
  double least = 1;
  for (int i = 0; i < 40; ++i) {
    Joint joint;
    joint.wavelength = 1e-6 + 0.6e-6 * random.uniform();
    joint.index = 1 + 0.5 * random.uniform();
    joint.mode_radius = 4e-6 + 3e-6 * random.uniform();
    joint.partner_mode_radius = 4e-6 + 3e-6 * random.uniform();
    joint.gap = i % 4 ? 60e-6 * random.uniform() : 0;
    const LightAxis from{pair(1.5e-6), pair(0.02)}, into{pair(1.5e-6), pair(0.02)};
    const double found = efficiency(joint_loss_dB(joint, from, into));
    EXPECT_CLOSE(found, overlap(joint, from, into), 1e-9) << i;
    least = std::min(least, found);
  }
  EXPECT_LT(least, 0.5);
}

// Marcuse 1977, in his form, with Z = lambda g/(2 pi n w^2).
TEST(JointLoss, OfAGapOrOfUnequalModesIsMarcuses) {
  Joint joint;
  for (const double gap : {5e-6, 40e-6, 300e-6}) {
    joint.gap = gap;
    const double z = 1550e-9 * gap / (2 * kPi * 1.4682 * 5.2e-6 * 5.2e-6);
    const double top = 4 * (4 * z * z + 1), bottom = (4 * z * z + 2) * (4 * z * z + 2) + 4 * z * z;
    EXPECT_CLOSE(efficiency(joint_loss_dB(joint, {})), top / bottom, 1e-12);
  }
  joint.gap = 0;
  joint.partner_mode_radius = 4.1e-6;
  const double ratio = 2 * 5.2 * 4.1 / (5.2 * 5.2 + 4.1 * 4.1);
  EXPECT_CLOSE(efficiency(joint_loss_dB(joint, {})), ratio * ratio, 1e-12);
}

// The way back: the modes change places, and a slope along the way out changes its sign.
TEST(JointLoss, IsTheSameForLightTheOtherWay) {
  Joint joint, back;
  joint.gap = back.gap = 25e-6;
  joint.partner_mode_radius = 4.4e-6;
  back.mode_radius = 4.4e-6;
  back.partner_mode_radius = joint.mode_radius;
  const LightAxis from = light(1e-6, -0.4e-6, 12e-3, 7e-3), into = light(0.2e-6, 0.3e-6, -5e-3, 0);
  EXPECT_CLOSE(joint_loss_dB(back, {into.offset, -into.slope}, {from.offset, -from.slope}),
               joint_loss_dB(joint, from, into), 1e-12);
}

TEST(LightAxis, GoesOnAlongTheInsertion) {
  Pose tip;
  tip << -300e-6, 0.2e-6, -0.1e-6, 1e-3, 2e-3;
  Joint joint;
  joint.gap = 20e-6;
  joint.offset = Vector2d(0.3e-6, 0);
  const LightAxis axis = light_axis(joint, tip);
  // The axis of the fibre itself, carried on by the gap along -x (sim/geometry/pose.hpp).
  const Vector2d there = tip.segment<2>(1) - joint.gap * tip.tail<2>() + joint.offset;
  EXPECT_LT((axis.offset + joint.gap * axis.slope - there).norm(), 1e-20);
}

// Two equal connectors, keys together: offsets towards the key meet and slopes towards it bend the
// way of the light; across the key it is the other way round.
TEST(PairLoss, SeesTheFacingConnectorFromItsOwnSide) {
  EXPECT_EQ(pair_loss_dB({}, light(1e-6, 0), light(1e-6, 0)), 0);
  EXPECT_EQ(pair_loss_dB({}, light(0, 0, 0, 3e-3), light(0, 0, 0, 3e-3)), 0);
  EXPECT_CLOSE(pair_loss_dB({}, light(0, 1e-6), light(0, 1e-6)), joint_loss_dB({}, light(0, 2e-6)),
               1e-14);
  EXPECT_CLOSE(pair_loss_dB({}, light(0, 0, 3e-3), light(0, 0, 3e-3)),
               joint_loss_dB({}, light(0, 0, 6e-3)), 1e-14);
}

TEST(PairLoss, DoesNotDependOnWhichSideIsWhichNorOnTurningBoth) {
  Joint joint;
  joint.gap = 15e-6;
  const LightAxis one = light(0.6e-6, 0.2e-6, 4e-3, -9e-3),
                  other = light(-0.3e-6, 0.5e-6, 2e-3, 6e-3);
  const double loss = pair_loss_dB(joint, one, other);
  EXPECT_CLOSE(pair_loss_dB(joint, other, one), loss, 1e-12);
  // Seen from the other side a turn has the other sense.
  EXPECT_CLOSE(pair_loss_dB(joint, turned(one, 0.7), turned(other, -0.7)), loss, 1e-12);
  EXPECT_GT(std::abs(pair_loss_dB(joint, turned(one, 0.7), other) / loss - 1), 0.01);
}

}  // namespace
}  // namespace ferrule
