#include "bench/capture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

constexpr double kPressed = 20;  // on a cleaved end, of the way that it has to slide

// Lowers a fibre from above the mouth at `offset` from the axis. Does it get deeper than `depth`
// into the bore?
bool goes_in(const World& world, const Vector2d& offset, double speed, double dt) {
  // A cleaved rim leads; a rounded one slides round the edge as the hand presses by its radius.
  const double edge = world.end.edge;
  const double above = 0.5e-6 + world.annulus.fibre_radius * world.end.cleave.norm();
  const double depth = 2.5e-6 + edge;
  const double aside = std::max(0.0, offset.norm() - world.annulus.clearance());
  const double tangent = world.profile.lead_in_tangent;
  // The mouth's height there; a cone as steep takes the soft hand `aside` times its tangent deeper.
  const double height = tangent > 0 ? std::min(world.profile.lead_in_length, aside / tangent) : 0;
  const double pressed = world.end.cleave.norm() > 0 ? kPressed : tangent;
  const double travel = above + height + aside * pressed + depth + 0.5e-6 + edge;
  Pose hand = Pose::Zero();
  hand[0] = above + height;
  hand.segment<2>(1) = offset;
  StepResult now(at_rest(world, hand));
  const auto steps = static_cast<long>(std::ceil(travel / (speed * dt)));
  for (long n = 1; n <= steps; ++n) {
    hand[0] = above + height - travel * static_cast<double>(n) / static_cast<double>(steps);
    step_on(world, hand, dt, now);
  }
  return now.state.tip[0] < -depth;
}

// A fibre's end over a bore, that of `paper`, rigid and upright, without forces.
struct End {
  double edge_um, cleave_deg;
  World world;

  bool as_it_is() const { return edge_um > 0 || cleave_deg > 0; }
};

// Cleaved ends have their foremost point in the direction 0.
End end_of(double edge_um, double cleave_deg, bool lead_in) {
  std::vector<std::string> settings = {"laws={}", "holder.tilt_stiffness_N_m_rad=1e6"};
  if (!lead_in) settings.emplace_back("ferrule.lead_in=null");
  if (edge_um > 0) settings.push_back("fibre.edge_um=" + std::to_string(edge_um));
  if (cleave_deg > 0) {
    settings.push_back("fibre.cleave_deg=" + std::to_string(cleave_deg));
    settings.emplace_back("fibre.cleave_direction_deg=0");
  }
  return {edge_um, cleave_deg, load_scene("paper", settings).world};
}

// From where the end is caught, at `angle` [clearances].
double capture_range(const World& world, double angle) {
  const Annulus& bore = world.annulus;
  const double edge = world.end.edge, c = bore.clearance();
  if (world.end.cleave.isZero())
    return (world.profile.mouth_radius() - bore.fibre_radius + edge) / c;
  // Its foremost point over the opening of a sharp bore: e + (r - edge) a within R.
  const double r = bore.fibre_radius - edge, across = r * std::sin(angle);
  return (std::sqrt(bore.bore_radius * bore.bore_radius - across * across) - r * std::cos(angle)) /
         c;
}

// Lowers the end at `offset` [clearances], in a direction in eighths of a turn; at two speeds and
// in steps of three lengths, ends as they are in the longer two. The end must outlive the cases.
void add_lowered(Cases<CaptureRow>& cases, const End& end, int direction, double offset) {
  for (const double speed : {5e-6, 50e-6})
    for (const double dt : {1e-4, 1e-3, 1e-2}) {
      if (end.as_it_is() && dt < 1e-3) continue;
      add_case(cases, [=, &end] {
        const double angle = direction * std::numbers::pi / 4;
        const Vector2d at =
            offset * end.world.annulus.clearance() * Vector2d(std::cos(angle), std::sin(angle));
        return CaptureRow{offset,
                          capture_range(end.world, angle),
                          45.0 * direction,
                          1e6 * speed,
                          dt,
                          end.edge_um,
                          end.cleave_deg,
                          end.world.profile.has_lead_in(),
                          goes_in(end.world, at, speed, dt)};
      });
    }
}

}  // namespace

std::vector<CaptureRow> bench_capture(const GoOn& go_on) {
  std::vector<End> ends = {end_of(0, 0, false), end_of(0, 0, true)};
  for (const double edge : {1.0, 5.0, 10.0})
    for (const bool lead_in : {false, true}) ends.push_back(end_of(edge, 0, lead_in));
  for (const double cleave : {0.5, 1.0}) ends.push_back(end_of(0, cleave, false));

  Cases<CaptureRow> cases;
  for (const End& end : ends)
    for (int k = 0; k < 8; ++k) {
      // Behind its foremost point a cleaved end is held by none.
      if (end.cleave_deg > 0 && k > 2 && k < 6) continue;
      if (!end.as_it_is())
        for (const double offset : {0.5, 0.9, 0.98, 1.02, 1.1, 1.5, 3.0, 10.0, 30.0})
          add_lowered(cases, end, k, offset);
      if (!end.as_it_is() && !end.world.profile.has_lead_in()) continue;
      const double caught = capture_range(end.world, k * std::numbers::pi / 4);
      const double near = end.cleave_deg > 0 ? 0.05 : 0.02;
      for (const double part : {0.9, 1 - near, 1 + near, 1.1, 3.0})
        add_lowered(cases, end, k, part * caught);
    }
  return rows_of(cases, go_on);
}

}  // namespace ferrule
