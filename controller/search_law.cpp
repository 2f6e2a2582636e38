#include "controller/search_law.hpp"

namespace ferrule {
namespace {

// The phases of ferrule_phase.
constexpr std::array kPhaseNames = {"approach", "centre", "touch",  "release",  "lift",
                                    "move",     "lower",  "insert", "back_off", "straighten"};
static_assert(kPhaseNames.size() == FERRULE_STRAIGHTEN + 1);

ferrule_axes in_c(const Eigen::Matrix<double, 5, 1>& v) noexcept {
  return {v[0], {v[1], v[2]}, {v[3], v[4]}};
}

}  // namespace

SearchLaw::SearchLaw(std::span<const double> g, const KnownHand& hand) noexcept {
  static_assert(sizeof(ferrule_numbers) == kSearchGains.size() * sizeof(double));
  const ferrule_numbers numbers = {g[0], g[1], g[2],  g[3],  g[4],  g[5],  g[6],  g[7],
                                   g[8], g[9], g[10], g[11], g[12], g[13], g[14], g[15]};
  ferrule_search_start(&search_, &numbers, hand.lag, hand.stiffness);
}

HandTwist SearchLaw::command(const Observation& o) noexcept {
  const ferrule_axes v =
      ferrule_search_command(&search_, {in_c(o.wrench), in_c(o.displacement), o.height, o.time});
  return (HandTwist() << v.x, v.across.y, v.across.z, v.about.y, v.about.z).finished();
}

const char* SearchLaw::phase_name() const noexcept {
  return kPhaseNames[search_.phase];
}

}  // namespace ferrule
