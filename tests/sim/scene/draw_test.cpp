#include "sim/scene/draw.hpp"

#include <algorithm>
#include <cmath>

#include "tests/compare.hpp"
#include "tests/scenes.hpp"

namespace ferrule {
namespace {

constexpr std::uint64_t kDraws = 2000;

// Fibres of that tolerance, in a bore that all of them fit.
std::vector<double> fibres(const std::string& tolerance) {
  const Scene scene =
      testing::bare({"ferrule.bore_diameter_um=130", "fibre.diameter_um=" + tolerance});
  std::vector<double> um;
  for (std::uint64_t trial = 0; trial < kDraws; ++trial)
    um.push_back(draw_scene(scene, 1, trial)->parameters.fibre.diameter_um);
  std::sort(um.begin(), um.end());
  return um;
}

// The largest distance of the empirical distribution from `cdf` is below Kolmogorov's 0.1 % point.
template <class Cdf>
void expect_distributed(const std::vector<double>& sorted, const Cdf& cdf) {
  const auto n = static_cast<double>(sorted.size());
  double largest = 0;
  for (std::size_t i = 0; i < sorted.size(); ++i)
    largest = std::max(largest, std::abs(cdf(sorted[i]) - (static_cast<double>(i) + 0.5) / n));
  EXPECT_LT(largest, 1.95 / std::sqrt(n));
}

TEST(Draw, AFibreBetweenTwoDiametersIsUniform) {
  const std::vector<double> um = fibres("124.25..125");
  EXPECT_GE(um.front(), 124.25 - 1e-9);
  EXPECT_LE(um.back(), 125 + 1e-9);
  expect_distributed(um, [](double x) { return (x - 124.25) / 0.75; });
}

TEST(Draw, AFibreAboutADiameterIsNormal) {
  const std::vector<double> um = fibres("125+-0.75");
  EXPECT_GE(um.front(), 124.25 - 1e-9);
  EXPECT_LE(um.back(), 125.75 + 1e-9);
  expect_distributed(um, [](double x) { return 0.5 * std::erfc(-(x - 125) / 0.25 / M_SQRT2); });
}

// In y and in z, with the variance of both parts: fibre 0.3, ferrule 0.4 um.
TEST(Draw, ACoreIsOffByWhatFibreAndFerruleAre) {
  const Scene scene =
      testing::bare({"joint.core_concentricity_sd_um=0.3", "joint.bore_concentricity_sd_um=0.4"});
  for (const char* along : {"y", "z"}) {
    std::vector<double> um;
    for (std::uint64_t trial = 0; trial < kDraws; ++trial)
      um.push_back(draw_scene(scene, 1, trial)->joint.offset[*along - 'y'] * 1e6);
    std::sort(um.begin(), um.end());
    expect_distributed(um, [](double x) { return 0.5 * std::erfc(-x / 0.5 / M_SQRT2); });
  }
  const auto drawn = draw_scene(scene, 1, 3);
  const Scene again = parse_scene(drawn->document, "drawn");
  EXPECT_EQ(again.joint.offset, drawn->joint.offset);
  EXPECT_EQ(draw_scene(again, 1, 4)->joint.offset, drawn->joint.offset);
  EXPECT_EQ(undrawn(again.document), scene.document);
}

TEST(Draw, ADrawnPairStatesWhatItWasDrawnFrom) {
  const Scene scene =
      testing::paper({"ferrule.bore_diameter_um=126..127", "fibre.diameter_um=125+0/-0.5"});
  const auto drawn = draw_scene(scene, 1, 3);
  const Scene again = parse_scene(drawn->document, "drawn");
  EXPECT_FALSE(again.tolerance);
  EXPECT_EQ(again.world.annulus.fibre_radius, drawn->world.annulus.fibre_radius);
  EXPECT_EQ(again.world.annulus.bore_radius, drawn->world.annulus.bore_radius);
  EXPECT_EQ(undrawn(again.document), scene.document);
}

}  // namespace
}  // namespace ferrule
