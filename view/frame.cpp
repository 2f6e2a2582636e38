#include "view/frame.hpp"

#include "insertion/scene_scaling.hpp"
#include "sim/geometry/contact_depth.hpp"
#include "sim/scene/terms.hpp"

namespace ferrule {
namespace {

constexpr double kMicro = 1e6;

// Normal force of a contact [N], pushing positive.
double normal_force(const Laws& laws, const ContactState& contact) noexcept {
  const double push = laws.wall ? wall(*laws.wall, contact.depth).force : 0;
  return push + adhesion_force(laws, contact.depth, contact.branch).force;
}

}  // namespace

std::vector<std::string> frame_columns() {
  std::vector<std::string> names = {"t_s"};
  for (const char* what : {"holder", "tip"})
    for (const char* of : {"_x_um", "_y_um", "_z_um", "_ay_rad", "_az_rad"})
      names.push_back(std::string(what) + of);
  for (const char* name : {"velocity_x_um_s", "velocity_y_um_s", "velocity_z_um_s", "force_x_uN",
                           "force_y_uN", "force_z_uN", "force_uN", "limit_uN", "depth_um",
                           "clearance_um", "tilt_rad", "way_y_um", "way_z_um"})
    names.push_back(name);
  for (const char* what : {"contact0", "contact1"})
    for (const char* of : {"_on", "_x_um", "_y_um", "_z_um", "_N_uN"})
      names.push_back(std::string(what) + of);
  for (const char* term : kTermNames)
    for (const char* of : {"_x_uN", "_y_uN", "_z_uN"}) names.push_back(std::string(term) + of);
  for (const char* name :
       {"bridge_on", "slip_on", "phase", "loss_dB", "loss_offset_um", "loss_tilt_rad", "period_us",
        "worst_period_us", "missed", "passivity_J"})
    names.push_back(name);
  return names;
}

FrameMaker::FrameMaker(const Scene& scene, const ForceSensor& sensor, double period) noexcept
    : scene_(scene),
      scaling_(scene_scaling(scene)),
      sensed_(scaling_, sensor, period, scene_tare(scene)) {}

Frame FrameMaker::operator()(const RowVector& row, const LoopHealth& health) noexcept {
  const auto [result, forces] = step_of(row);
  const State& state = result.state;
  const World& world = scene_.world;
  const bool first = !watch_;
  if (first) watch_.emplace(scene_, state);
  const std::optional<Outcome> seen = watch_->after(result, &forces[Term::friction]);
  sensed_.read(result.holder, state.command[0]);

  Frame frame{};
  std::size_t at = 0;
  const auto put = [&](double x) { frame[at++] = static_cast<float>(x); };
  const auto put_micro = [&](const auto& vector) {
    for (Eigen::Index i = 0; i < 3; ++i) put(kMicro * vector[i]);
  };
  put(row[kTime.begin]);
  for (const Pose& pose : {state.command, state.tip}) {
    put_micro(pose);
    put(pose[3]);
    put(pose[4]);
  }
  put_micro((row.segment<3>(kHandVelocity.begin) / scaling_.motion).eval());
  put_micro((sensed_.relative().head<3>() / scaling_.force).eval());
  put(kMicro * holder_force(world, result.holder).norm());
  put(kMicro * scene_.limits.force);
  put(kMicro * state.inserted_length());
  put(kMicro * smallest_gap(world, state));
  put(state.tip.tail<2>().norm());
  for (const double way : way_to_axis(world, state)) put(kMicro * way);
  const auto depths = contact_depths(world, contact_side(world, state.tip, state.side), state.tip);
  bool slips = false;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactState& contact = state.contact[place];
    const ContactState& before = contact_before_[place];
    const bool on = contact.closed && depths[place].value > -INFINITY;
    put(on);
    put_micro(on ? depths[place].point : Vector3d(Vector3d::Zero()));
    put(on ? kMicro * normal_force(world.laws, contact) : 0.0);
    slips = slips || (!first && contact.closed && before.closed && contact.stuck != before.stuck);
  }
  contact_before_ = state.contact;
  for (const Term term : kAllTerms) put_micro(forces.force(term));
  put(state.bridge);
  put(slips);
  put(static_cast<double>(phase_.after(state, seen)));
  const LightAxis light = light_axis(scene_.joint, state.tip);
  put(joint_loss_dB(scene_.joint, light));
  put(kMicro * light.offset.norm());
  put(light.slope.norm());
  put(kMicro * health.period);
  put(kMicro * health.worst);
  put(health.missed);
  put(health.passivity);
  return frame;
}

Json scene_json(const Scene& scene) {
  const World& world = scene.world;
  Json geometry = {{"fibre_radius_um", kMicro * world.annulus.fibre_radius},
                   {"bore_radius_um", kMicro * world.annulus.bore_radius},
                   {"bore_length_um", kMicro * world.profile.length},
                   {"lead_in_length_um", kMicro * world.profile.lead_in_length},
                   {"mouth_radius_um", kMicro * world.profile.mouth_radius()},
                   {"free_length_um", kMicro * world.holder.free_length}};
  if (const auto* liquid = std::get_if<Capillary>(&world.laws.capillary))
    geometry["liquid"] = {{"film_um", kMicro * liquid->film},
                          {"rupture_um", kMicro * liquid->rupture}};
  Json terms = Json::array();
  for (const Term term : kAllTerms)
    if (info(term).present(world.laws)) terms.push_back(info(term).name);
  return {{"name", scene.name},
          {"about", scene.document.value("about", "")},
          {"geometry", geometry},
          {"limits",
           {{"force_uN", kMicro * scene.limits.force},
            {"speed_um_s", kMicro * scene.limits.speed},
            {"time_s", scene.limits.time}}},
          {"start", {{"distance_um", kMicro * scene.start.distance}}},
          {"success_depth_um", kMicro * scene.success.depth},
          {"cue", scene.cue},
          {"terms", terms}};
}

}  // namespace ferrule
