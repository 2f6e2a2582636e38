#include <capture/episode.hpp>
#include <controller/trial.hpp>
#include <insertion/scene_scaling.hpp>
#include <iostream>
#include <learn/fit_law.hpp>
#include <sim/scene/draw.hpp>

int main(int, char** arguments) {
  using namespace ferrule;
  const Scene scene = load_scene(arguments[1], {"limits.speed_um_s=40"});
  StepResult now(draw_start(scene, 1, 1));
  State& state = now.state;
  Pose hand = state.command;
  for (int n = 0; n < 100; ++n) {
    hand[0] -= 10e-9;
    step_on(scene.world, hand, 1e-3, now);
  }
  std::cout << "tip at x = " << 1e6 * state.tip[0] << " um\n";
  ConstantVelocity controller(8e-3);
  std::cout << name(run_trial(scene, controller, 1, 1).outcome) << "\n";
}
