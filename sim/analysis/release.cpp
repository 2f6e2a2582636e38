#include "sim/analysis/release.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "sim/analysis/gap_forces.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr std::array kSurface = {Term::van_der_waals, Term::electrostatic, Term::capillary};
constexpr int kPanels = 400;                               // of the integral of a peel
constexpr double kFirstSeparation = 1e-12, kRatio = 1.02;  // separations that are looked at [m]
constexpr int kRefined = 60;                               // halvings about the largest

double& at(std::array<double, kTerms>& terms, Term term) {
  return terms[static_cast<std::size_t>(term)];
}

double sum(const std::array<double, kTerms>& terms) {
  return std::accumulate(terms.begin(), terms.end(), 0.0);
}

// That the holder leaves to the end [N].
double weight(const World& world) {
  return -world.holder.weight[1];
}

// Does the law know one gap, that at the fibre's middle?
bool knows_one_gap(const Laws& laws, Term term) {
  constexpr std::size_t printed = 1;  // of EitherForm
  return term == Term::van_der_waals   ? laws.van_der_waals.index() == printed
         : term == Term::electrostatic ? laws.electrostatic.index() == printed
                                       : laws.capillary.index() == printed;
}

class Contact {
 public:
  Contact(const World& world, double length, int places)
      : world_(world),
        length_(length),
        shared_(std::holds_alternative<printed::Adhesion>(world.laws.adhesion) ? 1 : places),
        places_(places) {
    if (const auto* law = std::get_if<Adhesion>(&world.laws.adhesion))
      branch_ = law->contact->curve.branches();
  }

  // Pull of `share` of all places at separation s.
  double adhesion(double s, double share) const {
    return -share * shared_ * adhesion_force(world_.laws, -s, branch_).force;
  }

  double surface(Term term, double gap) const {
    return 0 - force_at_gap(world_, term, {.gap = gap, .length = length_, .depth = {}});  // no -0
  }

  std::array<double, kTerms> lift(double s) const {
    std::array<double, kTerms> terms{};
    at(terms, Term::adhesion) = std::max(0.0, adhesion(s, 1));
    for (const Term term : kSurface)
      if (info(term).present(world_.laws)) at(terms, term) = surface(term, s);
    at(terms, Term::gravity) = weight(world_);
    return terms;
  }

  std::array<double, kTerms> peel(double s) const {
    std::array<double, kTerms> terms{};
    // With one place, at the end, the hand has nothing at the mouth to part.
    if (places_ == 2) at(terms, Term::adhesion) = std::max(0.0, adhesion(s, 0.5));
    for (const Term term : kSurface)
      if (info(term).present(world_.laws)) at(terms, term) = about_the_end(term, s);
    at(terms, Term::gravity) = weight(world_);
    return terms;
  }

 private:
  double about_the_end(Term term, double s) const {
    if (knows_one_gap(world_.laws, term)) return 0.5 * surface(term, 0.5 * s);
    double all = 0;
    for (int i = 0; i < kPanels; ++i) {
      const double u = (i + 0.5) / kPanels;
      all += u * surface(term, u * s) / kPanels;
    }
    return all;
  }

  const World& world_;
  double length_;
  int shared_, places_, branch_ = 0;
};

// The largest sum of `terms` over the separations up to `most`.
template <class Terms>
Release largest(ReleasePath path, double most, const Terms& terms) {
  double best = 0, force = sum(terms(0.0));
  const auto look = [&](double s) {
    const double f = sum(terms(s));
    if (f > force) force = f, best = s;
  };
  for (double s = kFirstSeparation; s < most; s *= kRatio) look(s);
  look(kInteratomicDistance);
  double reach = (kRatio - 1) * best;
  for (int i = 0; i < kRefined; ++i, reach *= 0.7)
    for (const double s : {best - reach, best + reach})
      if (s > 0 && s < most) look(s);
  return {path, force, best, terms(best)};
}

Release slide(const World& world, double length, int places, double speed) {
  const Contact contact(world, length, places);
  double load = weight(world);
  for (const Term term : kSurface)
    if (info(term).present(world.laws)) load += contact.surface(term, 0);
  Release r{ReleasePath::slide, 0, 0, {}};
  // The printed contact is one, with the radius that is prescribed.
  const bool shared = std::holds_alternative<printed::Adhesion>(world.laws.adhesion);
  const int count = shared ? 1 : places;
  if (const Friction* law = friction_law(world.laws))
    at(r.terms, Term::friction) = count * friction(*law, loaded_radius(world, load / count));
  for (const Term term : {Term::meniscus, Term::drag, Term::flow})
    if (info(term).present(world.laws))
      at(r.terms, term) =
          force_at_gap(world, term, {.gap = 0, .length = length, .depth = {}, .speed = speed});
  // What is ahead pulls no more than a vacuum.
  if (const auto& flow = world.laws.flow)
    at(r.terms, Term::flow) = std::min(
        at(r.terms, Term::flow), flow_area(world.annulus) * (kAtmosphere - flow->vapour_pressure));
  r.force = sum(r.terms);
  return r;
}

}  // namespace

double loaded_radius(const World& world, double load) noexcept {
  const auto* law = std::get_if<Adhesion>(&world.laws.adhesion);
  const int branch = law ? law->contact->curve.branches() : 0;
  if (!present(world.laws.adhesion) && !world.laws.wall) return 0;
  const auto pushes = [&](double depth) {
    double force = adhesion_force(world.laws, depth, branch).force;
    if (world.laws.wall) force += wall(*world.laws.wall, depth).force;
    return force >= load;
  };
  // The deepest crossing: from where it pushes more, back.
  double high = 1e-12;
  while (!pushes(high) && high < 1) high *= 2;
  double low = high;
  while (pushes(low) && low > 1e-16) low *= 0.5;
  if (pushes(low)) low = -1e-6;  // attraction alone holds it at a depth below 0
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    (pushes(middle) ? high : low) = middle;
  }
  return friction_radius(world, high, branch).value;
}

std::vector<Release> release(const World& world, double length, int places, double speed) {
  const Contact contact(world, length, places);
  const double most = world.annulus.clearance();
  Release lift = largest(ReleasePath::lift, most, [&](double s) { return contact.lift(s); });
  Release peel = largest(ReleasePath::peel, most, [&](double s) { return contact.peel(s); });
  // The end, alone.
  Release end = largest(ReleasePath::peel, most, [&](double s) {
    std::array<double, kTerms> terms{};
    at(terms, Term::adhesion) = std::max(0.0, contact.adhesion(s, 1.0 / places));
    at(terms, Term::gravity) = weight(world);
    return terms;
  });
  return {lift, end.force > peel.force ? end : peel, slide(world, length, places, speed)};
}

}  // namespace ferrule
