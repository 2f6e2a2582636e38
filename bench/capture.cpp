#include "bench/capture.hpp"

#include <cmath>
#include <numbers>

#include "sim/scene.hpp"
#include "sim/step.hpp"

namespace ferrule {
namespace {

// Lowers the hand from `from` to `to`; does the end get past `depth` into the bore?
bool goes_in(const World& world, const Pose& from, double to, double speed, double dt,
             double depth) {
  State state = at_rest(world, from);
  const auto steps = static_cast<long>(std::ceil((from[0] - to) / (speed * dt)));
  for (long n = 1; n <= steps; ++n) {
    Pose hand = from;
    hand[0] = from[0] + (to - from[0]) * static_cast<double>(n) / static_cast<double>(steps);
    state = step(world, state, hand, dt).state;
  }
  return state.tip[0] < -depth;
}

}  // namespace

std::vector<CaptureRow> bench_capture() {
  const std::vector<std::string> rigid = {"laws={}", "holder.tilt_stiffness_N_m_rad=1e6"};
  std::vector<std::string> sharp_edge = rigid;
  sharp_edge.push_back("ferrule.lead_in=null");
  const World sharp = load_scene("paper", sharp_edge).world;
  const World cone = load_scene("paper", rigid).world;
  const double clearance = sharp.annulus.clearance();
  const double reach = cone.profile.mouth_radius() - cone.annulus.fibre_radius;
  const double lead_in = cone.profile.lead_in_length;

  std::vector<CaptureRow> rows;
  for (const bool with_cone : {false, true})
    for (const double offset : {0.5, 0.9, 0.98, 1.02, 1.1, 1.5, 3.0, 10.0, 30.0})
      for (int k = 0; k < 8; ++k)
        for (const double speed : {5e-6, 50e-6})
          for (const double dt : {1e-4, 1e-3, 1e-2}) {
            if (with_cone && (offset > 3 || (speed < 50e-6 && dt < 1e-3))) continue;
            const double angle = k * std::numbers::pi / 4;
            const double e = offset * (with_cone ? reach : clearance);
            Pose from = Pose::Zero();
            from[0] = with_cone ? lead_in + 0.5e-6 : 0.5e-6;
            from[1] = e * std::cos(angle);
            from[2] = e * std::sin(angle);
            // Down a cone the soft hand has to push further than the fibre goes.
            const double to = with_cone ? -lead_in - 5e-6 : -3e-6;
            const bool in =
                goes_in(with_cone ? cone : sharp, from, to, speed, dt, with_cone ? 1e-6 : 2.5e-6);
            rows.push_back({offset, 45.0 * k, 1e6 * speed, dt, with_cone, in, offset < 1});
          }
  return rows;
}

}  // namespace ferrule
