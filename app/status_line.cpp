#include "app/status_line.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include "insertion/phase.hpp"

namespace ferrule {
namespace {

constexpr double kEvery = 0.1;  // [s]
constexpr std::size_t kBar = 20;

}  // namespace

std::string status_text(const RowVector& row, const Scene& scene) {
  const StepResult now = step_of(row).result;
  const double force = holder_force(scene.world, now.holder).norm();
  const double share = std::clamp(force / scene.limits.force, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(std::lround(share * kBar));
  const double gap = smallest_gap(scene.world, now.state), depth = now.state.inserted_length();
  const char* const gap_is = gap >= 0 ? "gap" : depth > 0 ? "pressed in" : "beside";
  return fmt::format(
      "{:6.1f} s  depth {:7.2f} um  {:<10} {:8.3f} um  force {:7.3f} of {:g} uN [{}{}]",
      row[kTime.begin], 1e6 * depth, gap_is, 1e6 * std::abs(gap), 1e6 * force,
      1e6 * scene.limits.force, std::string(filled, '#'), std::string(kBar - filled, ' '));
}

StatusLine::StatusLine(const Scene& scene) noexcept
    : scene_(scene), shown_(::isatty(STDERR_FILENO)) {}

StatusLine::~StatusLine() {
  if (shown_) std::fputs("\r\033[K", stderr);
}

void StatusLine::operator()(const RowVector& row) {
  const double t = row[kTime.begin];
  if (!shown_ || t < next_) return;
  next_ = t + kEvery;
  fmt::print(stderr, "\r\033[K{}", status_text(row, scene_));
}

}  // namespace ferrule
