#include "sim/laws/flow.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim/base/elementary.hpp"
#include "sim/laws/drag.hpp"

namespace ferrule {
namespace {

using std::numbers::pi;

constexpr double kFullest = 1 - 1e-6;  // of a blind bore's length: beyond it the force is held

double wide(const Annulus& annulus) noexcept {
  return std::max(annulus.clearance() + annulus.roughness, kThinnestFilm);
}

}  // namespace

double flow_area(const Annulus& annulus) noexcept {
  const double r = annulus.fibre_radius;
  return pi * r * (r + wide(annulus));
}

double annulus_resistance(const Flow& law, const Annulus& annulus, double length,
                          double mean_squared_eccentricity) noexcept {
  const double c = wide(annulus);
  return 6 * law.viscosity * length /
         (pi * annulus.fibre_radius * c * c * c * (1 + 1.5 * mean_squared_eccentricity));
}

double flow_resistance(const Flow& law, const Annulus& annulus, double bore_length, double length,
                       double mean_squared_eccentricity) noexcept {
  const double back = annulus_resistance(law, annulus, length, mean_squared_eccentricity);
  if (law.blind) return back;
  const double R = annulus.bore_radius;
  const double ahead =
      8 * law.viscosity * std::max(0.0, bore_length - length) / (pi * R * R * R * R);
  return back + ahead > 0 ? back * (ahead / (back + ahead)) : 0;
}

FlowStep::FlowStep(const Flow& law, const Annulus& annulus, double bore_length, double length,
                   double mean_squared_eccentricity, double air, double dt) noexcept
    : before_(length) {
  // Per length, which is that of the mouth where nothing is in yet.
  constexpr double kFirst = 1e-9;  // [m]
  const double l = std::max(length, kFirst);
  const double per_length =
      flow_resistance(law, annulus, bore_length, l, mean_squared_eccentricity) / l;
  if (law.cushions()) {
    cushions_ = true;
    area_ = flow_area(annulus);
    longest_ = bore_length;
    alpha_ = 0.5 * dt / (per_length * l);
    const double volume = area_ * (bore_length - std::min(length, kFullest * bore_length));
    amount_ = air + kAtmosphere * (volume + alpha_ * kAtmosphere);
    air_ = air;
    volume_before_ = volume;
  } else if (dt > 0) {
    area_ = flow_area(annulus);
    rate_ = area_ * area_ * per_length / dt;
    most_pull_ = area_ * (kAtmosphere - law.vapour_pressure);
  }
}

FlowStep::Cushion FlowStep::cushion_at(double length) const noexcept {
  const double volume = area_ * (longest_ - std::min(length, kFullest * longest_));
  const double root = std::sqrt(volume * volume + 4 * alpha_ * amount_);
  const double pressure = 2 * amount_ / (volume + root);
  // (p - p_0)(V + alpha (p + p_0)) = N - p_0 V - alpha p_0^2.
  const double over = (air_ + kAtmosphere * (volume_before_ - volume)) /
                      (volume + alpha_ * (pressure + kAtmosphere));
  return {volume, root, pressure, over};
}

AxialForce FlowStep::liquid_at(double length) const noexcept {
  const auto at = [this](double l) {
    const double more = l - before_;
    return AxialForce{rate_ * more * more * (l + 2 * before_) / 6,
                      0.5 * rate_ * more * (l + before_), rate_ * l};
  };
  AxialForce f = at(length);
  if (!(f.force < -most_pull_)) return f;
  // From where it cavitates the pull is constant.
  const double begins = std::sqrt(std::max(0.0, before_ * before_ - 2 * most_pull_ / rate_));
  f = at(begins);
  return {f.energy + most_pull_ * (begins - length), -most_pull_, 0};
}

AxialForce FlowStep::at(double length) const noexcept {
  if (!acts()) return {};
  if (!cushions_) return liquid_at(length);
  // - integral of (p - p_0) dV, by p dV = d(V N/(V + S) + N log(V + S)), without cancellation.
  const Cushion from = cushion_at(before_), now = cushion_at(length);
  const double more = now.volume - from.volume, both = now.volume + from.volume;
  const double sums = (now.volume + now.root) * (from.volume + from.root);
  const double grown = more * (1 + both / (now.root + from.root)) / (from.volume + from.root);
  const double shared = 4 * alpha_ * amount_ * more * both /
                        ((now.volume * from.root + from.volume * now.root) * sums);
  AxialForce f{kAtmosphere * more - amount_ * (shared + elementary::log1p(grown)), area_ * now.over,
               area_ * area_ * now.pressure / now.root};
  const double beyond = length - kFullest * longest_;
  if (beyond > 0) {
    f.energy += f.force * beyond;
    f.stiffness = 0;
  }
  return f;
}

double FlowStep::air_at(double length) const noexcept {
  if (!cushions_) return 0;
  const Cushion now = cushion_at(length);
  return now.over * now.volume;
}

}  // namespace ferrule
