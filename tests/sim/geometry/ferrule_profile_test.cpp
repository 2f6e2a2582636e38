#include "sim/geometry/ferrule_profile.hpp"

#include "tests/compare.hpp"

namespace ferrule {
namespace {

const double kTangent = std::tan(std::acos(-1) / 6);
const FerruleProfile kLeadIn = {63e-6, 62e-6 / kTangent, kTangent, 10e-3};
constexpr FerruleProfile kSharp = {63e-6, 0, 0, 10e-3};

TEST(FerruleProfile, ConeMeetsBoreAndFace) {
  EXPECT_CLOSE(kLeadIn.mouth_radius(), 125e-6, 1e-14);
  EXPECT_LT(std::abs(edge_depth(kLeadIn, 0, 63e-6).cone), 1e-19);
  EXPECT_LT(std::abs(edge_depth(kLeadIn, kLeadIn.lead_in_length, 125e-6).cone), 1e-18);
}

TEST(FerruleProfile, DepthIsDistanceAlongTheNormal) {
  // 1 um into the cone along its normal (-sin, cos).
  const double s = 0.5, c = std::sqrt(0.75);
  const double x = 30e-6, rho = 63e-6 + x * kTangent;
  EXPECT_CLOSE(edge_depth(kLeadIn, x - s * 1e-6, rho + c * 1e-6).cone, 1e-6, 1e-9);
}

TEST(FerruleProfile, AnEndKeepsTheSideItEnteredBy) {
  // 10 nm over the rim of a sharp bore and pressed 25 nm deep: nearer to the bore than to the face.
  const EdgeDepth pressed = edge_depth(kSharp, -25e-9, 63.01e-6);
  EXPECT_TRUE(pressed.inside());
  EXPECT_EQ(edge_side(pressed, EdgeSide::face), EdgeSide::face);
  EXPECT_EQ(edge_side(pressed, EdgeSide::throat), EdgeSide::throat);
  EXPECT_EQ(edge_side(edge_depth(kSharp, 1e-6, 63.01e-6), EdgeSide::throat), EdgeSide::face);
  EXPECT_EQ(edge_side(edge_depth(kSharp, -1e-6, 62.9e-6), EdgeSide::face), EdgeSide::throat);
}

}  // namespace
}  // namespace ferrule
