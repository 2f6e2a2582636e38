#include "sim/laws/adhesion.hpp"

#include <mutex>
#include <numbers>
#include <optional>

#include "sim/base/elementary.hpp"

namespace ferrule {

double reduced_modulus(double young_fibre, double poisson_fibre, double young_ferrule,
                       double poisson_ferrule) noexcept {
  return 4.0 / 3.0 /
         ((1 - poisson_fibre * poisson_fibre) / young_fibre +
          (1 - poisson_ferrule * poisson_ferrule) / young_ferrule);
}

namespace {

// The last curve that was tabulated is kept: most worlds of a run have the same.
MaugisCurve tabulated(double lambda) {
  static std::mutex mutex;
  static std::optional<MaugisCurve> last;
  const std::scoped_lock lock(mutex);
  if (!last || last->lambda() != lambda) last.emplace(lambda);
  return *last;
}

}  // namespace

MaugisContact::MaugisContact(double lambda, double work_of_adhesion, double reduced_modulus,
                             double sphere_radius)
    : curve(tabulated(lambda)),
      force(std::numbers::pi * work_of_adhesion * sphere_radius),
      depth(elementary::cbrt(force * force / (reduced_modulus * reduced_modulus * sphere_radius))),
      radius(elementary::cbrt(force * sphere_radius / reduced_modulus)) {}

Adhesion prepare(Adhesion law) {
  law.contact = std::make_shared<const MaugisContact>(law.maugis_lambda, law.work_of_adhesion,
                                                      law.reduced_modulus, law.radius);
  return law;
}

AdhesionForce adhesion(const Adhesion& law, double depth, int branch) noexcept {
  const MaugisContact& contact = *law.contact;
  const MaugisCurve::Value value = contact.curve.at(depth / contact.depth, branch);
  return {{contact.force * contact.depth * value.energy, contact.force * value.P,
           contact.force / contact.depth * value.slope},
          contact.radius * value.A,
          contact.radius / contact.depth * value.A_slope,
          value.branch};
}

}  // namespace ferrule
