#include "bench/peers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "bench/peers/peg.hpp"
#include "capture/episode.hpp"
#include "learn/loaded_library.hpp"
#include "sim/base/measure.hpp"
#include "sim/solver/step.hpp"

namespace ferrule {
namespace {

constexpr double kClearance = 0.5e-6;                // [m]
constexpr double kDepth = 400e-6, kSwing = 50e-6;    // [m]
constexpr double kRamp = 1, kRound = 6;              // [s]
constexpr double kAside = 1.5e-6, kBeyond = 0.5e-3;  // [m, rad]
constexpr double kAbove = 2e-6, kBelow = 8e-6;       // [m]
constexpr double kLowering = 50e-6;                  // [m/s]
constexpr double kWentIn = 4e-6;                     // deeper than that [m]

// The holder: its frequencies with the drawn fibre's mass, and the scene's spring that it is.
constexpr double kFrequency = 50, kTurning = 200;  // [rad/s]
constexpr double kStiffness = 0.5;                 // [N/m]
constexpr double kDrawnStiffness = kFrequency * kFrequency * peers::kMass;
constexpr double kDrawnTilt = kTurning * kTurning * peers::kTurn;
constexpr double kForce = kDrawnStiffness * peers::kDrawn / kStiffness;   // alpha_f
constexpr double kTiltStiffness = kDrawnTilt / (kForce * peers::kDrawn);  // [N m/rad]

// The hand of the motion, in the plane at `angle`.
struct Hand {
  double depth;  // [m]
  PlanarPose planar;
  double angle;  // [rad]

  Pose pose() const {
    const double c = std::cos(angle), s = std::sin(angle);
    Pose p;
    p << -depth, planar.e * c, planar.e * s, planar.tilt * c, planar.tilt * s;
    return p;
  }
};
Hand around(double t) {
  const double part = std::min(1.0, t / kRamp), turn = std::max(0.0, t - kRamp) / kRound;
  const double depth = kDepth - kSwing * std::sin(2 * std::numbers::pi * turn);
  // Tilted so that the end goes to the other side.
  return {depth,
          {part * kAside, part * (2 * kClearance / kDepth + kBeyond)},
          2 * std::numbers::pi * turn};
}

// An engine by way of the pose of the fibre's end, at the fibre's scale.
class Held {
 public:
  virtual ~Held() = default;
  virtual void reset(const Pose& tip) = 0;
  virtual Pose step(const Pose& hand, const Pose& next, double dt) = 0;
};

class Ours : public Held {
 public:
  explicit Ours(const World& world) : world_(world) {}
  void reset(const Pose& tip) override { now_ = StepResult(at_rest(world_, tip)); }
  Pose step(const Pose&, const Pose& next, double dt) override {
    step_on(world_, next, dt, now_);
    return now_.state.tip;
  }

 private:
  const World& world_;
  StepResult now_{State()};
};

class Theirs : public Held {
 public:
  explicit Theirs(std::unique_ptr<peers::Engine> engine) : engine_(std::move(engine)) {}

  void reset(const Pose& tip) override { engine_->reset(centre(tip)); }

  Pose step(const Pose& hand, const Pose& next, double dt) override {
    const peers::Motion now = engine_->motion();
    const Vector3d axis = now.turned * Vector3d::UnitX();
    const Vector3d end = now.at - 0.5 * peers::kPegLength * axis;
    const Vector3d wanted = axis_of(hand), rate = (axis_of(next) - wanted) / dt;
    const Vector3d velocity = (centre(next) - centre(hand)) / dt;
    const Vector3d pull = kDrawnStiffness * (peers::kDrawn * hand.head<3>() - end);
    const Vector3d force = pull + 2 * kFrequency * peers::kMass * (velocity - now.velocity);
    // Damped alike about all axes: by the inertia about each.
    const double about = axis.dot(now.spin);
    const Vector3d damped =
        peers::kTurn * (wanted.cross(rate) - now.spin + about * axis) - peers::kSpin * about * axis;
    const Vector3d moment =
        (end - now.at).cross(pull) + kDrawnTilt * axis.cross(wanted) + 2 * kTurning * damped;
    engine_->step(force, moment);
    const peers::Motion then = engine_->motion();
    const Vector3d a = then.turned * Vector3d::UnitX();
    Pose tip;
    tip << (then.at - 0.5 * peers::kPegLength * a) / peers::kDrawn, a.y() / a.x(), a.z() / a.x();
    return tip;
  }

 private:
  static Vector3d axis_of(const Pose& p) { return Vector3d(1, p[3], p[4]).normalized(); }
  static Vector3d centre(const Pose& tip) {
    return peers::kDrawn * tip.head<3>() + 0.5 * peers::kPegLength * axis_of(tip);
  }
  std::unique_ptr<peers::Engine> engine_;
};

void measure_motion(Held& fibre, PeerRow& row) {
  const double dt = row.step_s;
  const auto ramp = std::lround(kRamp / dt), all = std::lround((kRamp + kRound) / dt);
  fibre.reset(around(0).pose());
  double begin = thread_seconds(), force_error = 0, force = 0;
  std::vector<Pose> tips;
  for (long n = 0; n < all; ++n) {
    if (n == ramp) begin = thread_seconds();
    const double t = static_cast<double>(n) * dt;
    const Pose tip = fibre.step(around(t).pose(), around(t + dt).pose(), dt);
    if (n >= ramp) tips.push_back(tip);
  }
  row.us_per_simulated_ms = 1e3 * (thread_seconds() - begin) / kRound;
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const Hand hand = around(static_cast<double>(static_cast<long>(i) + ramp + 1) * dt);
    const Pose& tip = tips[i];
    // Where end and mouth are: the bore begins `length` from the end.
    const double length = std::max(0.0, -tip[0]);
    const PlanarPose right =
        held_in_bore(hand.planar, hand.depth, kClearance, kStiffness, kTiltStiffness);
    const Pose expected = Hand{hand.depth, right, hand.angle}.pose();
    const auto mouth = [](const Pose& p, double x) {
      return Vector2d(p.segment<2>(1) + x * p.segment<2>(3));
    };
    const Vector2d end = tip.segment<2>(1), edge = mouth(tip, length);
    const auto larger = [](double& most, double value) {
      if (!(value <= most)) most = value;  // NaN is the largest of all
    };
    larger(row.penetration_um, 1e6 * (std::max(end.norm(), edge.norm()) - kClearance));
    const Vector2d off = end - expected.segment<2>(1);
    larger(row.pose_error_um,
           1e6 * std::max(off.norm(), (edge - mouth(expected, hand.depth)).norm()));
    larger(force_error, kStiffness * off.norm());
    larger(force, kStiffness * std::abs(right.e - hand.planar.e));
  }
  row.force_error_relative = force_error / force;
}

void measure_let_in(Held& fibre, PeerRow& row) {
  const auto steps = std::lround((kAbove + kBelow) / kLowering / row.step_s);
  for (const double offset : {4.0, 5.0, 6.0, 8.0, 10.0, 15.0, 30.0, 60.0})
    for (const double angle : {0.0, std::numbers::pi / 24, 1.0, 2.5}) {
      const auto hand = [&](long n) {
        const double x = kAbove - kLowering * row.step_s * static_cast<double>(n);
        return Hand{-x, {offset * kClearance, 0}, angle}.pose();
      };
      fibre.reset(hand(0));
      Pose tip = hand(0);
      for (long n = 0; n < steps; ++n) tip = fibre.step(hand(n), hand(n + 1), row.step_s);
      ++row.outside;
      row.let_in += !(tip[0] > -kWentIn);
    }
}

PeerRow measured(Held& fibre, PeerRow row) {
  const double least = -std::numeric_limits<double>::infinity();
  row.pose_error_um = row.force_error_relative = row.penetration_um = least;
  measure_motion(fibre, row);
  measure_let_in(fibre, row);
  return row;
}

PeerRow row_of(std::string engine, std::string version, std::string settings, int segments,
               double step) {
  return {
      std::move(engine), std::move(version), std::move(settings), segments, step, 0, 0, 0, 0, 0, 0};
}

}  // namespace

PlanarPose held_in_bore(PlanarPose hand, double length, double c, double k,
                        double k_tilt) noexcept {
  // Every set of active constraints a e + b tilt = limit: none, one of four, an end and a mouth.
  PlanarPose best{0, 0};
  double least = std::numeric_limits<double>::infinity();
  const auto consider = [&](PlanarPose p) {
    const double slack = 1e-9 * c;
    if (std::abs(p.e) > c + slack || std::abs(p.e + length * p.tilt) > c + slack) return;
    const double energy = k * std::pow(p.e - hand.e, 2) + k_tilt * std::pow(p.tilt - hand.tilt, 2);
    if (energy < least) least = energy, best = p;
  };
  consider(hand);
  for (const double end : {-c, c}) {
    consider({end, hand.tilt});
    for (const double mouth : {-c, c}) consider({end, length > 0 ? (mouth - end) / length : 0});
  }
  for (const double mouth : {-c, c}) {
    // The least along e + length tilt = mouth.
    const double over = hand.e + length * hand.tilt - mouth;
    const double give = 1 / k + length * length / k_tilt;
    consider({hand.e - over / (k * give), hand.tilt - over * length / (k_tilt * give)});
  }
  return best;
}

PeerBench bench_peers(const GoOn& go_on) {
  PeerBench bench;
  const World world =
      load_scene("paper", {"laws={}", "ferrule.lead_in=null",
                           fmt::format("holder.stiffness_N_m={:.17g}", kStiffness),
                           fmt::format("holder.tilt_stiffness_N_m_rad={:.17g}", kTiltStiffness)})
          .world;
  Cases<PeerRow> cases;
  for (const double step : {1e-3, 1e-4})
    add_case(cases, [step, &world] {
      Ours ours(world);
      return measured(ours, row_of("ferrule", program_version(), "quasi-static", 0, step));
    });
  struct Known {
    const char *name, *library, *symbol, *package;
  };
  for (const Known& known :
       {Known{"ODE", "ferrule_ode.so", "ferrule_peers_ode", "libode-dev"},
        Known{"Bullet", "ferrule_bullet.so", "ferrule_peers_bullet", "libbullet-dev"},
        Known{"MuJoCo", "ferrule_mujoco.so", "ferrule_peers_mujoco",
              "mujoco of PyPI (docs/building.md)"}}) {
    try {
      const auto list = *static_cast<const peers::Peers*>(
          loaded_symbol(known.library, known.symbol, built_with(known.name, known.package)));
      for (const peers::Peer& peer : list())
        add_case(cases, [peer] {
          Theirs theirs(peer.make());
          return measured(
              theirs, row_of(peer.engine, peer.version, peer.settings, peer.segments, peer.step));
        });
    } catch (const BadInput& e) {
      bench.missing.push_back(std::string(known.name) + ": " + e.what());
    }
  }
  bench.rows = rows_of(cases, go_on);
  return bench;
}

}  // namespace ferrule
