#include "controller/search_law.hpp"

namespace ferrule {
namespace {

ferrule_axes in_c(const Eigen::Matrix<double, 5, 1>& v) noexcept {
  return {v[0], {v[1], v[2]}, {v[3], v[4]}};
}

}  // namespace

SearchLaw::SearchLaw(std::span<const double> g,
                     const std::optional<ferrule_own_hand>& own) noexcept {
  static_assert(sizeof(ferrule_numbers) == kSearchGains.size() * sizeof(double));
  const ferrule_numbers numbers = {g[0], g[1], g[2],  g[3],  g[4],  g[5],  g[6],  g[7],
                                   g[8], g[9], g[10], g[11], g[12], g[13], g[14], g[15]};
  ferrule_search_start(&search_, &numbers, own ? &*own : nullptr);
}

HandTwist SearchLaw::command(const Observation& o) noexcept {
  const ferrule_axes v = ferrule_search_command(
      &search_, {in_c(o.wrench), in_c(o.displacement), o.height, o.time, o.force_limit});
  return (HandTwist() << v.x, v.across.y, v.across.z, v.about.y, v.about.z).finished();
}

const char* SearchLaw::phase_name() const noexcept {
  return ferrule_phases[search_.phase].name;
}

}  // namespace ferrule
