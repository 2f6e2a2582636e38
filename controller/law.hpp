// The parametric laws by name, and any of them as a controller.
//
// Each may also yield to moments by tilting, about each axis for itself:
//   w_y = C_y M_y,   w_z = C_z M_z
// with w the rates of tilt [rad/s] and M the observed moments about the fibre's end, relative to
// those at rest [N m], in the hand's world. The gains C_y, C_z then follow those of the law's table.
#pragma once

#include <cassert>
#include <span>
#include <string>
#include <vector>

#include "controller/admittance_law.hpp"
#include "controller/insertion_law.hpp"

namespace ferrule {

// In the order of their numbers of gains: linear is contained in all others, insertion in guarded,
// phased in saturated.
enum class LawKind { linear, insertion, phased, guarded, saturated };
inline constexpr std::array kLaws = {LawKind::linear, LawKind::insertion, LawKind::phased,
                                     LawKind::guarded, LawKind::saturated};

constexpr const char* name(LawKind kind) noexcept {
  constexpr std::array names = {"linear", "insertion", "phased", "guarded", "saturated"};
  return names[static_cast<std::size_t>(kind)];
}

constexpr std::span<const Gain> gain_table(LawKind kind) noexcept {
  constexpr std::span<const Gain> admittance(kAdmittanceGains), insertion(kGainTable);
  switch (kind) {
    case LawKind::linear:
      return admittance.first(kLinearGains);
    case LawKind::phased:
      return admittance.first(kPhasedGains);
    case LawKind::saturated:
      return admittance;
    case LawKind::guarded:
      return insertion;
    case LawKind::insertion:
      break;
  }
  return insertion.first(kGains);
}

inline constexpr std::array<Gain, 2> kTiltGains = {{
    {"tilt_yield_y", "C_y", "rad/(s N m)", Gain::not_negative},
    {"tilt_yield_z", "C_z", "rad/(s N m)", Gain::not_negative},
}};

// The i-th gain of a law, be it one of its table or the tilt gains behind them.
constexpr const Gain& gain_of(LawKind kind, std::size_t i) noexcept {
  const std::span<const Gain> table = gain_table(kind);
  return i < table.size() ? table[i] : kTiltGains[i - table.size()];
}

// Is it the insertion law, be it with yields of its own inside the bore?
constexpr bool is_insertion_law(LawKind kind) noexcept {
  return kind == LawKind::insertion || kind == LawKind::guarded;
}

// Velocity [m/s] from gains in the order of the table. T is double, or a dual number.
template <class T>
Eigen::Matrix<T, 3, 1> law_velocity(LawKind kind, const T* gains, const Observation& observation) {
  const int count = static_cast<int>(gain_table(kind).size());
  if (is_insertion_law(kind)) return insertion_velocity(gains, count, observation);
  return admittance_velocity(gains, count, observation);
}

class Law : public Controller {
 public:
  // One number per gain of the table, and of one that tilts two more, of kTiltGains.
  Law(LawKind kind, std::vector<double> gains) : kind_(kind), gains_(std::move(gains)) {
    assert(gains_.size() == gain_table(kind).size() || tilts());
  }
  HandTwist command(const Observation& observation) noexcept override {
    HandTwist v = HandTwist::Zero();
    v.head<3>() = law_velocity(kind_, gains_.data(), observation);
    if (tilts())
      v.tail<2>() = Eigen::Map<const Eigen::Vector2d>(gains_.data() + gain_table(kind_).size())
                        .cwiseProduct(observation.wrench.tail<2>());
    return v;
  }
  LawKind kind() const noexcept { return kind_; }
  bool tilts() const noexcept {
    return gains_.size() == gain_table(kind_).size() + kTiltGains.size();
  }
  const std::vector<double>& gains() const noexcept { return gains_; }

 private:
  LawKind kind_;
  std::vector<double> gains_;
};

}  // namespace ferrule
