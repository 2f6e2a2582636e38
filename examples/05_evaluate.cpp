// usage: 05_evaluate FILE.json
// Let a learned law (04_fit makes one) and a controller of one's own insert fibres by themselves.
#include <cstdio>

#include "controller/campaign.hpp"
#include "controller/controller_file.hpp"
#include "insertion/scene_scaling.hpp"

using namespace ferrule;

// Straight in, and sideways wherever the fibre is pushed: from what the hand would feel [N] to how
// it would move [m/s].
class Yielding : public Controller {
 public:
  explicit Yielding(double speed) : speed_(speed) {}
  HandTwist command(const Observation& observation) noexcept override {
    HandTwist velocity = HandTwist::Zero();
    velocity[0] = -speed_;
    velocity.segment<2>(1) = kAdmittance * observation.wrench.segment<2>(1);
    return velocity;
  }

 private:
  static constexpr double kAdmittance = 0.01;  // [m/s per N]
  double speed_;
};

std::vector<TrialResult> evaluate(const char* what, const Scene& scene,
                                  const MakeController& make) {
  const std::uint64_t seed = 7;
  const std::size_t trials = 60;
  const int threads = 0;  // all cores; the result does not depend on it
  const auto results = run_campaign(scene, make, seed, trials, threads, [](std::size_t) {});
  const CampaignSummary s = summarise(results);
  std::printf("%-18s %zu of %zu inserted, %.0f %% (95 %% %.0f to %.0f)\n", what, s.successes,
              s.feasible, 100 * s.success_rate, 100 * s.wilson.low, 100 * s.wilson.high);
  return results;
}

int main(int argc, char** argv) {
  const Scene scene = load_scene("demo");
  const double speed = scene_scaling(scene).motion * scene.limits.speed;  // in the hand's world
  const auto naive =
      evaluate("constant velocity", scene, controller_maker(ConstantVelocity(speed)));
  const auto own = evaluate("yielding", scene, controller_maker(Yielding(0.5 * speed)));
  const auto law = evaluate("law", scene, load_controller(argc > 1 ? argv[1] : "controller.json"));
  // On the same trials, both insert more often than the one that yields to nothing.
  return compare(own, naive).difference > 0 && compare(law, naive).difference > 0 ? 0 : 1;
}
