#include "learn/shown_search.hpp"

#include <algorithm>
#include <cmath>

#include "controller/statistics.hpp"
#include "learn/samples.hpp"

namespace ferrule {
namespace {

using Eigen::Vector3d;

constexpr double kRowsApart = 0.05;    // between rows [s]
constexpr double kBeforeTouch = 0.05;  // the last of the way to it [s]
constexpr double kSlower = 1.5;        // times the touching speed: nearer it slowed down
constexpr double kTurned = 1e-3;       // less is no tilt [rad]

double median(const std::vector<double>& values) {
  return quantile(values, 0.5);
}

// When phase k ends [s], and the first row from a time on.
double end_of(const Demonstration& d, std::size_t k) {
  return k + 1 < d.phases.size() ? d.phases[k + 1].begin : d.period * static_cast<double>(d.rows());
}
Eigen::Index row_from(const Demonstration& d, double time) {
  return std::min(d.rows(), static_cast<Eigen::Index>(std::ceil(time / d.period - 1e-6)));
}

// Reads the phases of one demonstration.
class PhaseReader {
 public:
  PhaseReader(const Demonstration& d, double reaction, const SearchFile& search)
      : d_(d), reaction_(reaction), search_(search) {
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> force;
      for (Eigen::Index n = 0; n < end_row(0); ++n) force.push_back(d.observed(n).wrench[axis]);
      tare_[axis] = median(force);
    }
  }

  ShownSearch shown() {
    for (std::size_t k = 0; k < d_.phases.size(); ++k) {
      const std::string& phase = d_.phases[k].name;
      if (phase == "approach" || phase == "lower") come_near(k);
      if (phase == "touch") touch(k);
      if (phase == "release") release(k);
      if (phase == "lift") lift(k);
      if (phase == "move") move(k);
      if (phase == "insert") insert(k);
      if (phase == "straighten")
        push_ = ferrule_harder(push_, search_.gains[search_gain::push_force]);
    }
    slow_down();
    return found_;
  }

 private:
  std::string next(std::size_t k) const {
    return k + 1 < d_.phases.size() ? d_.phases[k + 1].name : "";
  }
  Eigen::Index first_row(std::size_t k) const { return row_from(d_, d_.phases[k].begin); }
  Eigen::Index end_row(std::size_t k) const { return row_from(d_, end_of(d_, k)); }
  void show(std::size_t gain, double value) {
    if (value > 0) found_.shown.push_back({gain, value});
  }
  double speed(Eigen::Index n) const { return -d_.velocity(n, 0); }

  // What was felt where phase k begins, one reaction time before: the axial force [N], and x [m].
  struct Felt {
    double force, x;
  };
  Felt felt(std::size_t k) const {
    const DemonstratedPhase& p = d_.phases[k];
    const double row = (p.begin - reaction_) / d_.period;
    const auto n = static_cast<Eigen::Index>(std::floor(row));
    const bool late = reaction_ > 0 && n + 1 < d_.rows();
    const double part = late && n >= 0 ? row - static_cast<double>(n) : 0.5;
    const Observation &before = late ? d_.observed(n) : p.before,
                      &after = late ? d_.observed(n + 1) : p.then;
    return {(1 - part) * before.wrench[0] + part * after.wrench[0] - tare_[0],
            (1 - part) * before.displacement[0] + part * after.displacement[0]};
  }

  void come_near(std::size_t k) {
    if (d_.phases[k].name == "approach" && !touched_)
      for (Eigen::Index n = first_row(k); n < end_row(k); n += stride_)
        show(search_gain::approach_speed, speed(n));
    if (next(k) != "touch") return;
    touched_ = true;
    show(search_gain::touch_force, felt(k + 1).force);
    for (Eigen::Index n = std::max(first_row(k), row_from(d_, end_of(d_, k) - kBeforeTouch));
         n < end_row(k); ++n)
      show(search_gain::touch_speed, speed(n));
  }

  void touch(std::size_t k) {
    if (next(k).empty()) return;
    show(search_gain::hold_time, end_of(d_, k) - d_.phases[k].begin - reaction_);
    const double tilt = d_.phases[k].then.displacement.tail<2>().norm();
    if (tilt > kTurned) show(search_gain::tilt, tilt);
  }

  void release(std::size_t k) {
    if (k + 1 == d_.phases.size()) return;
    const Felt from = felt(k), to = felt(k + 1);
    if (to.x > from.x) stiffness_ = (from.force - to.force) / (to.x - from.x);
  }

  // The law comes off slowly at first; it lifts further by what the end's rim comes lower by the next
  // tilt.
  void lift(std::size_t k) {
    double fastest = 0;
    for (Eigen::Index n = first_row(k); n < end_row(k); ++n) fastest = std::max(fastest, -speed(n));
    for (Eigen::Index n = first_row(k); n < end_row(k); ++n)
      if (-speed(n) > 0.5 * fastest) show(search_gain::insert_speed, -speed(n));
    if (!(stiffness_ > 0) || lifted_ || k + 2 >= d_.phases.size()) return;
    lifted_ = true;
    const Felt from = felt(k), to = felt(k + 1);
    const double tilt = d_.phases[k + 2].then.displacement.tail<2>().norm();
    show(search_gain::lift,
         to.x - from.x - from.force / stiffness_ - search_.gains[search_gain::fibre_radius] * tilt);
  }

  void move(std::size_t k) {
    double fastest = 0;
    for (Eigen::Index n = first_row(k); n + 1 < end_row(k); ++n)
      fastest = std::max(
          fastest,
          (d_.observed(n + 1).displacement - d_.observed(n).displacement).tail<2>().norm());
    if (fastest > 0.1 * kTurned) show(search_gain::tilt_rate, fastest / d_.period);
  }

  void insert(std::size_t k) {
    const auto delay = static_cast<Eigen::Index>(std::lround(reaction_ / d_.period));
    const auto felt_at = [&](Eigen::Index n) {
      Vector3d force = d_.observed(n - delay).wrench.head<3>() - tare_;
      force[0] = std::max(0.0, force[0]);
      return force;
    };
    std::vector<double> free;
    for (Eigen::Index n = first_row(k) + delay; n < end_row(k); ++n)
      if (felt_at(n).norm() < search_.gains[search_gain::touch_force]) free.push_back(speed(n));
    const double fast = free.empty() ? 0 : quantile(free, 0.75);
    if (!(fast > 0)) return;
    for (Eigen::Index n = first_row(k) + delay; n < end_row(k); n += stride_)
      found_.pushed.push_back({felt_at(n), d_.velocity.row(n).transpose(), fast, push_,
                               search_.gains[search_gain::yield]});
  }

  // Where the first way to a touch, or into the bore, became slow.
  void slow_down() {
    const std::vector<double> far = found_.of(search_gain::approach_speed),
                              near = found_.of(search_gain::touch_speed);
    if (far.empty() || near.empty()) return;
    const double fast = median(far), slow = median(near);
    if (fast < kSlower * slow) return;
    for (std::size_t k = 0; k < d_.phases.size(); ++k) {
      if (d_.phases[k].name != "approach" || (next(k) != "touch" && next(k) != "insert")) continue;
      Eigen::Index n = end_row(k);
      while (n > first_row(k) && speed(n - 1) < 0.5 * (fast + slow)) --n;
      if (n > first_row(k) && n < end_row(k))
        show(search_gain::near_entrance, d_.observed(n).height);
      return;
    }
  }

  const Demonstration& d_;
  double reaction_;
  const SearchFile& search_;
  Eigen::Index stride_ = std::max<Eigen::Index>(1, std::lround(kRowsApart / d_.period));
  Vector3d tare_ = Vector3d::Zero();
  double stiffness_ = 0, push_ = search_.gains[search_gain::push_force];
  bool touched_ = false, lifted_ = false;
  ShownSearch found_;
};

// The rows of its longest insertion: what a hand answers to force elsewhere is not lateral.
Demonstration inserting(const Demonstration& d) {
  Eigen::Index first = 0, end = 0;
  for (std::size_t k = 0; k < d.phases.size(); ++k) {
    const Eigen::Index from = row_from(d, d.phases[k].begin), to = row_from(d, end_of(d, k));
    if (d.phases[k].name != "insert" || to - from <= end - first) continue;
    first = from;
    end = to;
  }
  Demonstration part;
  part.period = d.period;
  part.speed_limit = d.speed_limit;
  part.observations.assign(d.observations.begin() + first, d.observations.begin() + end);
  part.velocity = d.velocity.middleRows(first, end - first);
  part.tilt_rates = d.tilt_rates.middleRows(first, end - first);
  return part;
}

}  // namespace

std::vector<ShownSearch> shown_by(const std::vector<const Demonstration*>& demonstrations,
                                  double reaction, const SearchFile& search) {
  std::vector<ShownSearch> all;
  for (const Demonstration* d : demonstrations)
    all.push_back(PhaseReader(*d, reaction, search).shown());
  return all;
}

double reaction_while_inserting(const std::vector<const Demonstration*>& demonstrations) {
  std::vector<Demonstration> parts;
  for (const Demonstration* d : demonstrations) parts.push_back(inserting(*d));
  std::vector<const Demonstration*> all;
  for (const Demonstration& part : parts) all.push_back(&part);
  return reaction_time(all);
}

}  // namespace ferrule
