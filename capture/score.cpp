#include "capture/score.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <unsupported/Eigen/FFT>
#include <utility>
#include <vector>

#include "insertion/scene_scaling.hpp"
#include "insertion/simulated_operator.hpp"

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

// Sees where movements begin (capture/score.hpp).
class MovementWatch {
 public:
  MovementWatch(double limit, double period)
      : limit_(limit), window_(std::max<std::size_t>(1, std::lround(kAverage / period)), 0.0) {}

  // Whether one begins with the next velocity.
  bool begins(double velocity) {
    double& oldest = window_[seen_++ % window_.size()];
    sum_ += velocity - std::exchange(oldest, velocity);
    const double v = sum_ / static_cast<double>(window_.size());
    if (direction_ != 0 && v * direction_ < kEnds * limit_) direction_ = 0;
    if (direction_ != 0 || !(std::abs(v) > kBegins * limit_)) return false;
    direction_ = v > 0 ? 1 : -1;
    return true;
  }

 private:
  double limit_, sum_ = 0;
  std::vector<double> window_;
  std::size_t seen_ = 0;
  int direction_ = 0;
};

using Spectrum = std::vector<std::complex<double>>;

// The first `count` numbers of the spectrum of `speed`, padded to kPadding times the next power of
// two. Of every kPadding-th number from one on, and of every so many samples from one on, there is
// a transform of its own, so that a long recording takes no more memory than these numbers:
//   X[k] = sum over r of exp(-2 pi i r k / (P N)) X_r[k],  X_r[P q + s] =
//   sum over m of (x[m D + r] exp(-2 pi i s m D / (P N))) exp(-2 pi i q m D / N)
// with N the padded length over P = kPadding, and D the samples, so few that the frequency at which
// X_r repeats is above the cut-off.
Spectrum begin_of_spectrum(const Eigen::Ref<const Eigen::VectorXd>& speed, double period,
                           std::size_t count) {
  const auto size = static_cast<std::size_t>(speed.size());
  const std::size_t n = std::bit_ceil(size);
  const std::size_t repeats = std::max<std::size_t>(1, std::size_t(1 / (kCutOff * period)));
  const std::size_t every = std::min(n, std::bit_floor(repeats)), length = n / every;
  const auto turn = [](std::size_t part, std::size_t whole) {
    return std::polar(1.0, -2 * std::numbers::pi * double(part % whole) / double(whole));
  };
  Eigen::FFT<double> fft;
  Spectrum all(count), samples(length), transformed;
  for (std::size_t s = 0; s < kPadding; ++s)
    for (std::size_t r = 0; r < every; ++r) {
      for (std::size_t m = 0; m < length; ++m) {
        const std::size_t at = m * every + r;
        samples[m] =
            at < size ? speed[static_cast<Eigen::Index>(at)] * turn(s * m, kPadding * length) : 0.0;
      }
      transformed = samples;  // of a single number
      if (length > 1) fft.fwd(transformed, samples);
      for (std::size_t k = s; k < count; k += kPadding)
        all[k] += turn(r * k, kPadding * n) * transformed[k / kPadding];
    }
  return all;
}

// What a hand did in a phase that cost most of a part, and what it should do instead.
std::string advice(const Measures& m, Part part, std::size_t phase) {
  const double all = m[part], there = m.by_phase[static_cast<std::size_t>(part)][phase];
  const char* const where = kWhere[phase];
  const double off = m.off_axis[phase], touched = m.touched_off_axis;
  const std::string cause =
      touched > m.clearance
          ? fmt::format(" after you touched {:.2g} um off the axis", 1e6 * touched)
          : "";
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
    return fmt::format("the fibre touched for {:.1f} s, {:.1f} s of it {}{}: line up before that",
                       all, there, where, cause);
  std::string text = std::string("you pushed ") + where;
  if (part == Part::peak_force) text += fmt::format(" with {:.3g} uN", 1e6 * all);
  if (!cause.empty()) return text + cause + ": correct sideways first";
  if (off <= m.clearance) return text + ": push more gently";
  return text + fmt::format(" while off the axis by {:.2g} um: correct sideways first", 1e6 * off);
}

}  // namespace

double spectral_arc_length(const Eigen::Ref<const Eigen::VectorXd>& speed, double period) {
  const auto size = static_cast<std::size_t>(speed.size());
  if (size == 0 || !(speed.cwiseAbs().maxCoeff() > 0)) return 0;
  const std::size_t padded = kPadding * std::bit_ceil(size);
  const double step = 1 / (static_cast<double>(padded) * period);  // [Hz]
  const auto in_band = static_cast<std::size_t>(std::floor(kCutOff / step)) + 1;
  const Spectrum spectrum = begin_of_spectrum(speed, period, std::min(in_band, padded / 2 + 1));
  const auto height = [&](std::size_t i) { return std::abs(spectrum[i]) / std::abs(spectrum[0]); };
  std::size_t last = spectrum.size() - 1;
  while (last > 0 && height(last) < kThreshold) --last;
  double length = 0;
  for (std::size_t i = 0; i < last; ++i)
    length += Eigen::Vector2d(1 / static_cast<double>(last), height(i + 1) - height(i)).norm();
  return -length;
}

int movements(const Eigen::VectorXd& velocity, double limit, double period) {
  MovementWatch watch(limit, period);
  return static_cast<int>(
      std::count_if(velocity.begin(), velocity.end(), [&](double v) { return watch.begins(v); }));
}

namespace {

// Measures an insertion as its rows come; of each it keeps the speed alone.
class MeasuredInsertion {
 public:
  MeasuredInsertion(const Scene& scene, double period)
      : scene_(scene),
        period_(period),
        movement_(scene_scaling(scene).motion * scene.limits.speed, period) {
    m_.clearance = scene.world.annulus.clearance();
  }

  void add(const RowVector& row);
  Measures result(Outcome outcome);

 private:
  double& at(Part part, Phase phase) {
    return m_.by_phase[static_cast<std::size_t>(part)][place(phase)];
  }
  void add_force(const StepResult& result, Phase phase);

  const Scene& scene_;
  double period_;
  std::optional<InsertionWatch> watch_;  // from the first row on
  PhaseWatch phases_;
  MovementWatch movement_;
  Measures m_{};
  double start_ = 0, deepest_ = 0, depth_ = 0, contact_ = 0, impulse_ = 0, work_ = 0;
  int moved_ = 0;
  std::vector<double> speed_;  // until the goal
};

void MeasuredInsertion::add(const RowVector& row) {
  const auto [result, forces] = step_of(row);
  if (!watch_) {
    watch_.emplace(scene_, result.state);
    start_ = deepest_ = result.state.tip[0];
  }
  const bool before = watch_->summary().reached < 0;
  if (before) speed_.push_back(row.segment<3>(kCommand.begin).norm());
  const std::optional<Outcome> seen = watch_->after(result, &forces[Term::friction]);
  const InsertionSummary& summary = watch_->summary();
  // The row that reaches the goal is on the way to it.
  const bool arrives = summary.reached == result.state.time;
  const Phase phase = phases_.after(result.state, arrives ? std::nullopt : seen);
  if (movement_.begins(row[kCommand.begin]) && moved_++ > 0) ++at(Part::corrections, phase);
  depth_ = std::max(depth_, summary.depth);
  deepest_ = std::min(deepest_, result.state.tip[0]);
  at(Part::friction_work, phase) += summary.friction_work - work_;
  work_ = summary.friction_work;
  if (summary.reached < 0) at(Part::time, phase) += period_;
  add_force(result, phase);
}

void MeasuredInsertion::add_force(const StepResult& result, Phase phase) {
  const double now = holder_force(scene_.world, result.holder).norm();
  if (now > at(Part::peak_force, phase)) {
    at(Part::peak_force, phase) = now;
    m_.off_axis[place(phase)] = way_to_axis(scene_.world, result.state).norm();
  }
  if (!result.state.contact[kEnd].closed && !result.state.contact[kSide].closed) return;
  if (contact_ == 0) m_.touched_off_axis = way_to_axis(scene_.world, result.state).norm();
  at(Part::contact_time, phase) += period_;
  at(Part::mean_force, phase) += period_ * now;
  contact_ += period_;
  impulse_ += period_ * now;
}

Measures MeasuredInsertion::result(Outcome outcome) {
  const InsertionSummary& summary = watch_->summary();
  const Eigen::Map<const Eigen::VectorXd> speed(speed_.data(),
                                                static_cast<Eigen::Index>(speed_.size()));
  m_.parts = {summary.task_time(),
              summary.peak_force,
              contact_ > 0 ? impulse_ / contact_ : 0,
              summary.friction_work,
              -spectral_arc_length(speed, period_),
              std::max(0.0, moved_ - 1.0),
              contact_};
  m_.outcome = outcome;
  m_.completion = std::min(1.0, depth_ / scene_.success.depth);
  m_.progress = std::clamp((start_ - deepest_) / (start_ + scene_.success.depth), 0.0, 1.0);
  return m_;
}

}  // namespace

Measures measure(const EpisodeRows& episode, const Scene& scene) {
  MeasuredInsertion measured(scene, episode.info().period);
  for (Eigen::Index n = 0; n < episode.count(); ++n) measured.add(episode.row(n));
  return measured.result(episode.info().outcome);
}

std::optional<Yardstick> yardstick(const Scene& scene) {
  constexpr std::uint64_t kSeed = 0x79617264;  // nobody else's
  std::array<std::vector<double>, kParts> all;
  for (int trial = 1; trial <= kReferences; ++trial) {
    const TrialSetup setup = feasible_setup(scene, kSeed, static_cast<std::uint64_t>(trial));
    const auto hand = simulated_operator(setup, 1);
    MeasuredInsertion measured(*setup.scene, kControlPeriod);
    const InsertionEnd end =
        run_insertion(setup, *hand, {.past_success = true}, [&](const Tick& tick) {
          measured.add(make_row(tick));
          return true;
        });
    if (end.outcome != Outcome::inserted) continue;
    const Measures m = measured.result(end.outcome);
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
