#include "bench/capture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/scene/scene.hpp"
#include "sim/step.hpp"

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
  State state = at_rest(world, hand);
  const auto steps = static_cast<long>(std::ceil(travel / (speed * dt)));
  for (long n = 1; n <= steps; ++n) {
    hand[0] = above + height - travel * static_cast<double>(n) / static_cast<double>(steps);
    state = step(world, state, hand, dt).state;
  }
  return state.tip[0] < -depth;
}

struct Lowered {
  double capture, offset;  // [clearances]
  double edge_um = 0, cleave_deg = 0;
};

// Fibres lowered so in a direction, in eighths of a turn, at two speeds and in steps of three
// lengths. The world must outlive them.
void add_lowered(Cases<CaptureRow>& cases, const World& world, const Lowered& l, int direction) {
  for (const double speed : {5e-6, 50e-6})
    for (const double dt : {1e-4, 1e-3, 1e-2}) {
      if ((l.edge_um > 0 || l.cleave_deg > 0) && dt < 1e-3) continue;
      add_case(cases, [=, &world] {
        const double angle = direction * std::numbers::pi / 4;
        const Vector2d at =
            l.offset * world.annulus.clearance() * Vector2d(std::cos(angle), std::sin(angle));
        return CaptureRow{l.offset,
                          l.capture,
                          45.0 * direction,
                          1e6 * speed,
                          dt,
                          l.edge_um,
                          l.cleave_deg,
                          world.profile.has_lead_in(),
                          goes_in(world, at, speed, dt)};
      });
    }
}

// How far aside the foremost point of a cleaved end is over a sharp bore, e + r a within R, at
// `angle` from a [clearances]; r without the rounding of the rim.
double cleaved_range(const World& world, double angle) {
  const Annulus& bore = world.annulus;
  const double r = bore.fibre_radius - world.end.edge, across = r * std::sin(angle);
  return (std::sqrt(bore.bore_radius * bore.bore_radius - across * across) - r * std::cos(angle)) /
         bore.clearance();
}

}  // namespace

std::vector<CaptureRow> bench_capture(const GoOn& go_on) {
  const std::vector<std::string> rigid = {"laws={}", "holder.tilt_stiffness_N_m_rad=1e6"};
  std::vector<std::string> sharp_edge = rigid;
  sharp_edge.push_back("ferrule.lead_in=null");
  const World sharp = load_scene("paper", sharp_edge).world;
  const World cone = load_scene("paper", rigid).world;
  const double range =
      (cone.profile.mouth_radius() - cone.annulus.fibre_radius) / cone.annulus.clearance();
  const std::vector<double> offsets = {0.5, 0.9, 0.98, 1.02, 1.1, 1.5, 3.0, 10.0, 30.0};

  // Ends with a rounded rim, which are caught from its radius farther out.
  struct End {
    double edge_um;
    World sharp, cone;
  };
  std::vector<End> ends;
  for (const double edge : {1.0, 5.0, 10.0}) {
    const auto with = [&](std::vector<std::string> settings) {
      settings.push_back("fibre.edge_um=" + std::to_string(edge));
      return load_scene("paper", settings).world;
    };
    ends.push_back({edge, with(sharp_edge), with(rigid)});
  }

  // Cleaved ends, their foremost points in the direction 0.
  std::vector<std::pair<double, World>> cleaved;
  for (const double cleave : {0.5, 1.0}) {
    std::vector<std::string> settings = sharp_edge;
    settings.push_back("fibre.cleave_deg=" + std::to_string(cleave));
    settings.push_back("fibre.cleave_direction_deg=0");
    cleaved.emplace_back(cleave, load_scene("paper", settings).world);
  }

  Cases<CaptureRow> cases;
  const auto lower = [&](const World& world, double capture, double offset, double edge_um = 0) {
    for (int k = 0; k < 8; ++k) add_lowered(cases, world, {capture, offset, edge_um}, k);
  };
  for (const double offset : offsets) lower(sharp, 1, offset);
  for (const double offset : offsets) lower(cone, range, offset);
  for (const double part : {0.9, 0.98, 1.02, 1.1, 3.0}) lower(cone, range, part * range);
  for (const End& end : ends)
    for (const World* world : {&end.sharp, &end.cone}) {
      const double caught =
          (world->profile.mouth_radius() - world->annulus.fibre_radius + 1e-6 * end.edge_um) /
          world->annulus.clearance();
      for (const double part : {0.9, 0.98, 1.02, 1.1, 3.0})
        lower(*world, caught, part * caught, end.edge_um);
    }
  for (const auto& [cleave, world] : cleaved)
    for (const int k : {0, 1, 2, 6, 7}) {
      const double caught = cleaved_range(world, k * std::numbers::pi / 4);
      for (const double part : {0.9, 0.95, 1.05, 1.1, 3.0})
        add_lowered(cases, world, {caught, part * caught, 0, cleave}, k);
    }
  return rows_of(cases, go_on);
}

}  // namespace ferrule
