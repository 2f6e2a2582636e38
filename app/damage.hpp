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

// What verbs that insert say of the first of them: a note where the scene's limit on the force is
// above it, otherwise nothing; and an object of their JSON.
std::string damage_note(const Scene& scene);
Json damage_json(const Scene& scene);

}  // namespace ferrule
