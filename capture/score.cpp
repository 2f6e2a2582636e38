#include "capture/score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <unsupported/Eigen/FFT>

#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"
#include "sim/scene/draw.hpp"

namespace ferrule {
namespace {

constexpr std::size_t kPadding = 16;
constexpr double kCutOff = 20;  // [Hz]
constexpr double kThreshold = 0.05;
constexpr double kAverage = 0.2;              // of the axial velocity: two periods of tremor [s]
constexpr double kBegins = 0.2, kEnds = 0.1;  // a movement, over the speed limit

// Phase as a place, and how it is said.
std::size_t place(Phase phase) noexcept {
  return static_cast<std::size_t>(phase);
}
constexpr std::array kWhere = {"in front of the ferrule",
                               "on the face",
                               "on the cone",
                               "in the bore",
                               "against the bore's wall",
                               "against both walls of the bore",
                               "after the goal",
                               "with the fibre wedged in the bore"};
static_assert(kWhere.size() == kPhases.size());

// What the yardstick is divided by, and what is divided.
double amount(const std::array<double, kParts>& parts, std::size_t part) {
  return parts[part] + (part == static_cast<std::size_t>(Part::corrections) ? 1 : 0);
}

bool about_contact(std::size_t part) {
  return part == static_cast<std::size_t>(Part::mean_force) ||
         part == static_cast<std::size_t>(Part::friction_work) ||
         part == static_cast<std::size_t>(Part::contact_time);
}

// Where movements begin: rows.
std::vector<Eigen::Index> movement_begins(const Eigen::VectorXd& velocity, double limit,
                                          double period) {
  const auto width = std::max<Eigen::Index>(1, std::lround(kAverage / period));
  std::vector<Eigen::Index> begins;
  int direction = 0;
  double sum = 0;
  for (Eigen::Index n = 0; n < velocity.size(); ++n) {
    sum += velocity[n] - (n >= width ? velocity[n - width] : 0.0);
    const double v = sum / static_cast<double>(width);
    if (direction != 0 && v * direction < kEnds * limit) direction = 0;
    if (direction == 0 && std::abs(v) > kBegins * limit) {
      direction = v > 0 ? 1 : -1;
      begins.push_back(n);
    }
  }
  return begins;
}

// What a hand did in a phase that cost most of a part, and what it should do instead.
std::string advice(const Measures& m, Part part, std::size_t phase) {
  const double all = m[part], there = m.by_phase[static_cast<std::size_t>(part)][phase];
  const char* const where = kWhere[phase];
  const double off = m.off_axis[phase];
  if (part == Part::smoothness)
    return "your speed was uneven (trembling, stops, sudden starts): move steadily";
  if (phase == place(Phase::seated)) return "you pressed on after the goal: stop there";
  if (part == Part::time)
    return fmt::format("you took {:.1f} s, {:.1f} s of it {}: move faster there", all, there,
                       where);
  if (part == Part::corrections)
    return fmt::format("you stopped or turned back {} {}: line up first, then push on",
                       there == 1 ? "once" : fmt::format("{:.0f} times", there), where);
  if (part == Part::contact_time)
    return fmt::format("the fibre touched for {:.1f} s, {:.1f} s of it {}: line up before that",
                       all, there, where);
  std::string text = std::string("you pushed ") + where;
  if (part == Part::peak_force) text += fmt::format(" with {:.3g} uN", 1e6 * all);
  if (off <= m.clearance) return text + ": push more gently";
  return text + fmt::format(" while off the axis by {:.2g} um: correct sideways first", 1e6 * off);
}

}  // namespace

double spectral_arc_length(const Eigen::VectorXd& speed, double period) {
  const auto size = static_cast<std::size_t>(speed.size());
  if (size == 0 || !(speed.cwiseAbs().maxCoeff() > 0)) return 0;
  const std::size_t padded = kPadding * std::bit_ceil(size);
  std::vector<double> profile(padded, 0.0);
  std::copy(speed.begin(), speed.end(), profile.begin());
  std::vector<std::complex<double>> spectrum;
  Eigen::FFT<double> fft;
  fft.SetFlag(Eigen::FFT<double>::HalfSpectrum);
  fft.fwd(spectrum, profile);
  const double step = 1 / (static_cast<double>(padded) * period);  // [Hz]
  const auto in_band = static_cast<std::size_t>(std::floor(kCutOff / step)) + 1;
  std::vector<double> height(std::min(in_band, spectrum.size()));
  for (std::size_t i = 0; i < height.size(); ++i)
    height[i] = std::abs(spectrum[i]) / std::abs(spectrum[0]);
  std::size_t last = height.size() - 1;
  while (last > 0 && height[last] < kThreshold) --last;
  double length = 0;
  for (std::size_t i = 0; i < last; ++i)
    length += std::hypot(1 / static_cast<double>(last), height[i + 1] - height[i]);
  return -length;
}

int movements(const Eigen::VectorXd& velocity, double limit, double period) {
  return static_cast<int>(movement_begins(velocity, limit, period).size());
}

Measures measure(const Episode& episode, const Scene& scene) {
  const Rows& rows = episode.rows;
  const double period = episode.info.period;
  InsertionWatch watch(scene, step_of(rows.row(0)).result.state);
  PhaseWatch phases;
  Measures m{};
  m.clearance = scene.world.annulus.clearance();
  const auto at = [&m](Part part, Phase phase) -> double& {
    return m.by_phase[static_cast<std::size_t>(part)][place(phase)];
  };
  double depth = 0, contact = 0, force = 0, deepest = rows(0, kStates.begin), work = 0;
  std::vector<Phase> phase_of;
  Eigen::Index arrived = rows.rows();  // rows until the goal
  for (Eigen::Index n = 0; n < rows.rows(); ++n) {
    const auto [result, forces] = step_of(rows.row(n));
    const std::optional<Outcome> seen = watch.after(result, &forces[Term::friction]);
    // The row that reaches the goal is on the way to it.
    const bool arrives = watch.summary().reached == result.state.time;
    if (arrives) arrived = n + 1;
    const Phase phase =
        phase_of.emplace_back(phases.after(result.state, arrives ? std::nullopt : seen));
    depth = std::max(depth, watch.summary().depth);
    deepest = std::min(deepest, result.state.tip[0]);
    const double now = holder_force(scene.world, result.holder).norm();
    if (now > at(Part::peak_force, phase)) {
      at(Part::peak_force, phase) = now;
      m.off_axis[place(phase)] = way_to_axis(scene.world, result.state).norm();
    }
    at(Part::friction_work, phase) += watch.summary().friction_work - work;
    work = watch.summary().friction_work;
    if (watch.summary().reached < 0) at(Part::time, phase) += period;
    const bool touches = result.state.contact[kEnd].closed || result.state.contact[kSide].closed;
    if (!touches) continue;
    at(Part::contact_time, phase) += period;
    at(Part::mean_force, phase) += period * now;
    contact += period;
    force += period * now;
  }
  const double motion = scene_scaling(scene).motion;
  const Eigen::VectorXd speed =
      rows.topRows(arrived).middleCols<3>(kCommand.begin).rowwise().norm();
  const auto begins =
      movement_begins(rows.col(kCommand.begin), motion * scene.limits.speed, period);
  for (std::size_t i = 1; i < begins.size(); ++i)
    ++at(Part::corrections, phase_of[static_cast<std::size_t>(begins[i])]);
  const InsertionSummary& summary = watch.summary();
  m.parts = {summary.task_time(),
             summary.peak_force,
             contact > 0 ? force / contact : 0,
             summary.friction_work,
             -spectral_arc_length(speed, period),
             begins.empty() ? 0.0 : static_cast<double>(begins.size() - 1),
             contact};
  m.outcome = episode.info.outcome;
  m.completion = std::min(1.0, depth / scene.success.depth);
  const double from = rows(0, kStates.begin);
  m.progress = std::clamp((from - deepest) / (from + scene.success.depth), 0.0, 1.0);
  return m;
}

std::optional<Yardstick> yardstick(const Scene& scene) {
  constexpr std::uint64_t kSeed = 0x79617264;  // nobody else's
  std::array<std::vector<double>, kParts> all;
  for (int trial = 1; trial <= kReferences; ++trial) {
    const FeasibleTrial drawn = feasible_trial(scene, kSeed, static_cast<std::uint64_t>(trial));
    const State start = draw_start(*drawn.scene, kSeed, drawn.trial);
    Episode episode;
    const auto hand =
        simulated_operator(*drawn.scene, start, 1, episode.info.period, kSeed, drawn.trial);
    std::vector<RowVector> rows;
    const InsertionEnd end = run_insertion(
        *drawn.scene, start, *hand, ForceSensor(drawn.scene->sensor, kSeed, drawn.trial),
        {.scaling = scene_scaling(scene), .period = episode.info.period, .past_success = true},
        [&](const Tick& tick) {
          rows.push_back(make_row(tick));
          return true;
        });
    if (end.outcome != Outcome::inserted) continue;
    episode.info.outcome = end.outcome;
    episode.rows.resize(static_cast<Eigen::Index>(rows.size()), Eigen::NoChange);
    for (std::size_t n = 0; n < rows.size(); ++n)
      episode.rows.row(static_cast<Eigen::Index>(n)) = rows[n];
    const Measures m = measure(episode, *drawn.scene);
    for (std::size_t part = 0; part < kParts; ++part) all[part].push_back(m.parts[part]);
  }
  if (all[0].empty()) return std::nullopt;
  Yardstick median{};
  for (std::size_t part = 0; part < kParts; ++part) {
    const auto middle = all[part].begin() + static_cast<std::ptrdiff_t>(all[part].size() / 2);
    std::nth_element(all[part].begin(), middle, all[part].end());
    median.parts[part] = *middle;
  }
  return median;
}

Score score(const Measures& m, const Yardstick& yardstick) {
  const bool inserted = m.outcome == Outcome::inserted;
  const bool touched = m[Part::contact_time] > 0;
  Score s{};
  double sum = 0, shown = 0;
  for (std::size_t i = 0; i < kParts; ++i) {
    const double own = amount(m.parts, i), best = amount(yardstick.parts, i);
    s.parts[i] = own <= best ? 1 : best / own;
    if (!touched && about_contact(i)) s.parts[i] = std::numeric_limits<double>::quiet_NaN();
    if (!inserted && i == static_cast<std::size_t>(Part::time)) s.parts[i] = 0;
    if (std::isnan(s.parts[i])) continue;
    sum += s.parts[i];
    ++shown;
  }
  s.total = inserted ? 100 * sum / shown : 50 * m.progress * sum / kParts;
  return s;
}

std::string hint(const Measures& m, const Score& s) {
  constexpr double kWorthSaying = 0.9;
  std::size_t worst = kParts;
  // What fails has no marks for its time, whatever was amiss: unless it never touched.
  const bool timed = m.outcome == Outcome::inserted || !(m[Part::contact_time] > 0);
  for (std::size_t i = 0; i < kParts; ++i) {
    if (!timed && i == static_cast<std::size_t>(Part::time)) continue;
    if (s.parts[i] < (worst < kParts ? s.parts[worst] : kWorthSaying)) worst = i;
  }
  if (worst == kParts) return "";
  const auto& phases = m.by_phase[worst];
  const auto most = std::max_element(phases.begin(), phases.end()) - phases.begin();
  return advice(m, static_cast<Part>(worst), static_cast<std::size_t>(most));
}

}  // namespace ferrule
