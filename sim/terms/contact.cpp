#include "sim/terms/contact.hpp"

#include <cmath>
#include <utility>

#include "sim/terms/surface.hpp"

namespace ferrule {
namespace {

// What the end cuts off the side's contact: its energy U times the share S of the length, which
// grows by -1 with x and by `ahead` with the tilts.
void cut(Potential& there, const PatchShare& share, const Vector2d& ahead,
         const PoseVector& tip) noexcept {
  ContactForce &wall = there.push[kSide], &adhesion = there.pull[kSide];
  there.push_out = share.slope * wall.potential;
  there.pull_out = share.slope * adhesion.potential;
  const double out = there.push_out + there.pull_out;
  const double bend = share.curve * (wall.potential + adhesion.potential);
  // S' dU, by the eccentricity at the mouth.
  const Vector2d turn =
      share.slope * (wall.force + adhesion.force) * there.depth[kSide].slope.tail<2>();
  const double along = turn.dot(tip.t), arm = -tip.x;
  Energy& bore = there.bore;
  bore.gradient.x -= out;
  bore.gradient.t += out * ahead;
  bore.force_scale += std::abs(there.push_out) + std::abs(there.pull_out);
  const Matrix2d mixed = turn * ahead.transpose();
  bore.hessian.xx += bend + 2 * along;
  bore.hessian.xe -= turn;
  bore.hessian.xt -= (bend + along) * ahead + arm * turn;
  bore.hessian.et += mixed;
  bore.hessian.tt += bend * ahead * ahead.transpose() + arm * (mixed + mixed.transpose());
  for (ContactForce* part : {&wall, static_cast<ContactForce*>(&adhesion)}) {
    part->potential *= share.value;
    part->force *= share.value;
    part->slope *= share.value;
  }
}

}  // namespace

double side_share(const World& world, const FrozenCoefficients& frozen,
                  const PoseVector& tip) noexcept {
  const double past = frozen.contact.past_mouth(tip, world.annulus.fibre_radius);
  return past < kPatch ? PatchShare(past).value : 1.0;
}

ContactForce push_at(const World& world, double depth) noexcept {
  const std::optional<Wall>& law = world.laws.wall;
  return law && depth != -INFINITY ? wall(*law, depth) : ContactForce{};
}

AdhesionForce pull_at(const World& world, double depth, int branch) noexcept {
  return depth != -INFINITY ? adhesion_force(world.laws, depth, branch) : AdhesionForce{};
}

void cut_patch(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
               Potential& potential) noexcept {
  const double r = world.annulus.fibre_radius, past = frozen.contact.past_mouth(tip, r);
  if (past > 0 && past < kPatch)
    cut(potential, PatchShare(past), r * frozen.contact.mouth_outward, tip);
}

void ContactTerm::add(const World&, const FrozenCoefficients&, const PoseVector& tip,
                      Potential& potential) noexcept {
  Energy& bore = potential.bore;
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const ContactForce& push = potential.push[at];
    const AdhesionForce& pull = potential.pull[at];
    bore.value += push.potential + pull.potential;
    bore.value_scale += push.potential + std::abs(pull.potential);
    const double force = push.force + pull.force;
    const double stiffness = push.slope + pull.slope;
    if (force == 0 && stiffness == 0) continue;
    bore.force_scale += push.force + std::abs(pull.force);
    potential.depth[at].add_to(bore, tip.t, force, stiffness);
  }
}

void ContactTerm::report(const World& world, const FrozenCoefficients& frozen,
                         const PoseVector& tip, const Potential& potential, Breakdown& b) noexcept {
  for (std::size_t at = 0; at < kContactPlaces; ++at) {
    const ContactDepth& depth = potential.depth[at];
    if (depth.value == -INFINITY) continue;
    const Vector3d normal = depth.normal(tip.t);
    b[Term::wall][at] = {potential.push[at].force * normal, depth.point};
    b[Term::adhesion][at] = {potential.pull[at].force * normal, depth.point};
  }
  if (potential.push_out == 0 && potential.pull_out == 0) return;
  const Vector2d rim = tip.e + world.annulus.fibre_radius * frozen.contact.mouth_outward;
  for (const auto& [term, force] :
       {std::pair(Term::wall, potential.push_out), std::pair(Term::adhesion, potential.pull_out)}) {
    PointForce& at_end = b[term][kEnd];
    at_end.force.x() += force;
    at_end.point = {tip.x, rim.x(), rim.y()};
  }
}

Contacts contacts(const World& world, const FrozenCoefficients& frozen, const PoseVector& tip,
                  const Potential& potential) noexcept {
  Contacts now;
  now.bridge =
      frozen.contact.side == EdgeSide::throat && bridge_at(world, frozen.bridge, whole(world, tip));
  for (int place = 0; place < kContactPlaces; ++place) {
    const auto at = static_cast<std::size_t>(place);
    const double depth = potential.depth[at].value;
    if (depth == -INFINITY) continue;
    ContactState& contact = now.contact[at];
    contact.closed = depth > 0 || potential.pull[at].radius > 0;
    contact.depth = contact.closed ? depth : 0.0;
    contact.branch = potential.pull[at].branch;
  }
  return now;
}

bool contact_set_changed(const State& before, const Contacts& now) noexcept {
  for (std::size_t place = 0; place < kContactPlaces; ++place)
    if (before.contact[place].closed != now.contact[place].closed ||
        before.contact[place].branch != now.contact[place].branch)
      return true;
  return before.bridge != now.bridge;
}

}  // namespace ferrule
