// Load a scene, push the fibre into the bore step by step, print where its end is and which forces
// act on it.
#include <cstdio>

#include "sim/scene/scene.hpp"
#include "sim/solver/step.hpp"

int main() {
  using namespace ferrule;
  // The scene "paper", which ships with the program; any value of it can be set.
  const Scene scene = load_scene("paper", {"holder.stiffness_N_m=500"});

  // x points out of the bore: the end starts 5 um outside and 0.2 um below the bore's axis.
  Pose tip = Pose::Zero();
  tip[0] = 5e-6;
  tip[1] = -0.2e-6;
  StepResult now(at_rest(scene.world, tip));

  // The holder holds the fibre by a spring. It is commanded 25 um in, in steps of 1 ms at 10 um/s.
  const double dt = 1e-3, speed = 10e-6;
  Pose command = now.state.command;
  for (int n = 0; n < 2500; ++n) {
    command[0] -= speed * dt;
    step_on(scene.world, command, dt, now);
    if (now.status != StepStatus::ok) return 1;
  }
  const State& state = now.state;

  std::printf("inserted %.3f um, the end at y = %.1f nm, z = %.1f nm\n",
              1e6 * state.inserted_length(), 1e9 * state.tip[1], 1e9 * state.tip[2]);
  const Breakdown breakdown = forces(scene.world, now);
  for (const Term term : kAllTerms) {
    const Vector3d force = breakdown.force(term);
    std::printf("%-14s %9.4f %9.4f %9.4f uN\n", kTermNames[static_cast<std::size_t>(term)],
                1e6 * force.x(), 1e6 * force.y(), 1e6 * force.z());
  }

  // The fibre is at rest: all that acts on it is felt at the holder.
  const Wrench& holder = now.holder;
  std::printf("%-14s %9.4f %9.4f %9.4f uN\n", "holder", 1e6 * holder[0], 1e6 * holder[1],
              1e6 * holder[2]);
  const double imbalance = (breakdown.sum(state.tip) - holder).head<3>().norm();
  return state.inserted_length() > 15e-6 && imbalance < 1e-4 * holder.head<3>().norm() ? 0 : 1;
}
