#include "bench/parts.hpp"

#include "controller/campaign.hpp"
#include "insertion/scene_scaling.hpp"
#include "learn/candidates.hpp"

namespace ferrule {
namespace {

struct Part {
  std::string name;
  std::vector<std::string> settings;
};

// The fluid that the scene has in its bore.
std::string flow(const Scene& scene, const char* bore) {
  Json law = {{"form", "corrected"}, {"bore", bore}};
  if (const auto& drag = scene.world.laws.drag) {
    law["fluid"] = "liquid";
    law["viscosity_Pa_s"] = drag->viscosity;
    law["vapour_pressure_kPa"] = 0;
  } else {
    law["fluid"] = "gas";
    law["viscosity_Pa_s"] = 1.8e-5;
  }
  return "laws.flow=" + law.dump();
}

std::vector<Part> parts_of(const Scene& scene) {
  return {{"as shipped", {}},
          {"curl of 4 m", {"fibre.curl_radius_m=4"}},
          {"entrance to 5 um", {"sensor.entrance_sd_um=5"}},
          {"flow, open bore", {flow(scene, "open")}},
          {"flow, blind bore", {flow(scene, "blind")}},
          {"cleave of 1 degree", {"fibre.cleave_deg=1"}},
          {"edge of 3 um", {"fibre.edge_um=3"}},
          {"ovality of 0.2 um", {"ferrule.ovality_um=0.2"}},
          {"a particle of 0.3 um",
           {R"(laws.particle={"form":"corrected","number":1,"median_um":0.3,"spread":0.8})"}}};
}

PartRow measured(const std::string& name, const Part& part, const char* controller,
                 std::uint64_t seed, std::size_t trials) {
  const Scene scene = load_scene(name, part.settings);
  const Scaling scaling = scene_scaling(scene);
  const double speed = scaling.motion * scene.limits.speed;
  const bool straight = std::string(controller) == "constant velocity";
  const MakeController make =
      straight ? controller_maker(ConstantVelocity(speed)) : controller_maker(tuned_by_hand(speed));
  const CampaignSummary summary =
      summarise(run_campaign(scene, make, seed, trials, 0, [](std::size_t) {}));
  return {name, part.name, controller, summary.feasible, summary.successes, summary.wilson};
}

}  // namespace

std::vector<PartRow> bench_parts(std::uint64_t seed, std::size_t trials,
                                 const std::vector<std::string>& scenes, const GoOn& go_on) {
  Cases<PartRow> cases;
  for (const std::string& name : scenes)
    for (const Part& part : parts_of(load_scene(name)))
      for (const char* controller : {"constant velocity", "tuned by hand"})
        add_case(cases, [=] { return measured(name, part, controller, seed, trials); });
  return rows_of(cases, go_on);
}

}  // namespace ferrule
