// The forces at which the fibre of a scene takes damage (sim/analysis/damage.hpp), beside the
// scene's limit.
#pragma once

#include <array>
#include <string>

#include "sim/scene/scene.hpp"

namespace ferrule {

// What damage depends on beside the world.
struct DamageInput {
  double stress_GPa, edge_um;  // the stress that is allowed, and the radius of the end's edge
};
// As the scene states it; unless it does, the usual proof stress of telecom fibre, and polished.
DamageInput damage_input(const Scene& scene);

struct Damage {
  const char *name, *what;
  double force;  // [N]; infinite: it does not happen
};
std::array<Damage, 4> damages(const Scene& scene, const DamageInput& input);

// The damage that a growing force does first. The end's edge decides it, and where the scene does
// not state its radius it may be anything from that of a cleaved end to that of a polished one.
struct FirstDamage {
  Damage sharpest, roundest;        // the same where the edge is stated
  double sharpest_um, roundest_um;  // radii of the edge
  bool at_centre;  // chance decides what it depends on, which is taken at its centre
};
FirstDamage first_damage(const Scene& scene);
// "ring, from 63.3 uN (edge of 0.02 um, as cleaved) to 3165 uN (1 um, polished)"
std::string to_text(const FirstDamage& damage);

// What verbs that insert say of it: a note where the scene's limit on the force is above it,
// otherwise nothing; and an object of their JSON, of which `force_uN` is that of the roundest edge.
// Where chance decides the limit the highest one counts; `limit_uN` is as the scene states it.
std::string damage_note(const Scene& scene);
Json damage_json(const Scene& scene);

}  // namespace ferrule
