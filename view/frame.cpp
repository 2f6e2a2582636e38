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

// What the columns are made of.
struct Shown {
  const Scene& scene;
  const RowVector& row;
  const LoopHealth& health;
  const State& state;
  const Breakdown& forces;
  Vector3d velocity, felt;  // of the holder [m/s]; [N]
  double force;             // at the holder, weight apart [N]
  std::array<ContactDepth, kContactPlaces> depths;
  bool slips;
  Phase phase;
  LightAxis light;
};

bool touches(const Shown& s, ContactPlace place) noexcept {
  return s.state.contact[place].closed && s.depths[place].value > -INFINITY;
}

Pose in_um(const Pose& pose) noexcept {
  Pose p = pose;
  p.head<3>() *= kMicro;
  return p;
}

// Calls visit(name, endings, value) for the columns, in their order: `name` with each of the
// endings, a word each; value(shown) is their number or vector.
template <class Visit>
constexpr void for_each_column(const Visit& visit) {
  using S = const Shown&;
  const char *const none = "", *const pose = "_x_um _y_um _z_um _ay_rad _az_rad";
  const char* const force = "_x_uN _y_uN _z_uN";
  visit("t_s", none, [](S s) { return s.row[kTime.begin]; });
  // Pose of the fibre's holder, as that of an end that nothing bends; pose of the fibre's end.
  visit("holder", pose, [](S s) { return in_um(s.state.command); });
  visit("tip", pose, [](S s) { return in_um(s.state.tip); });
  // Of the holder, until this row.
  visit("velocity", "_x_um_s _y_um_s _z_um_s", [](S s) { return Vector3d(kMicro * s.velocity); });
  // Of the fibre on the holder as the force sensor reads it, less what it read at rest: what is
  // felt.
  visit("force", force, [](S s) { return Vector3d(kMicro * s.felt); });
  // Magnitude at the holder, weight apart, and the most that is allowed: what ends an insertion.
  visit("force_uN", none, [](S s) { return kMicro * s.force; });
  visit("limit_uN", none, [](S s) { return kMicro * s.scene.limits.force; });
  // Inserted length, >= 0.
  visit("depth_um", none, [](S s) { return kMicro * s.state.inserted_length(); });
  // Smallest gap between fibre and bore, at its mouth or at the fibre's end; outside of it, what
  // the end has left or lacks (< 0) to go in.
  visit("clearance_um", none, [](S s) { return kMicro * smallest_gap(s.scene.world, s.state); });
  // Angle between the axes.
  visit("tilt_rad", none, [](S s) { return s.state.tip.tail<2>().norm(); });
  // How far the hand has to move sideways to be in the middle of the bore (insertion/phase.hpp).
  visit("way", "_y_um _z_um",
        [](S s) { return Vector2d(kMicro * way_to_axis(s.scene.world, s.state)); });
  // The rim of the end and the side on the bore's mouth: 1 where it touches, where on the fibre,
  // and its normal force, pushing positive; 0 where it does not.
  const auto contact = [&](const char* name, auto place) {
    visit(name, "_on", [=](S s) { return touches(s, place) ? 1.0 : 0.0; });
    visit(name, "_x_um _y_um _z_um", [=](S s) {
      return touches(s, place) ? Vector3d(kMicro * s.depths[place].point) : Vector3d::Zero().eval();
    });
    visit(name, "_N_uN", [=](S s) {
      return touches(s, place) ? kMicro * normal_force(s.scene.world.laws, s.state.contact[place])
                               : 0.0;
    });
  };
  contact("contact0", kEnd);
  contact("contact1", kSide);
  // Force on the fibre.
  for (const Term term : kAllTerms)
    visit(kTermNames[static_cast<std::size_t>(term)], force,
          [=](S s) { return Vector3d(kMicro * s.forces.force(term)); });
  // 1 while liquid spans the gap; 1 where a contact slipped in this row.
  visit("bridge_on", none, [](S s) { return s.state.bridge ? 1.0 : 0.0; });
  visit("slip_on", none, [](S s) { return s.slips ? 1.0 : 0.0; });
  // Place in kPhases (insertion/phase.hpp).
  visit("phase", none, [](S s) { return static_cast<double>(s.phase); });
  // Of the joint, were it to end here (sim/scene/joint.hpp).
  visit("loss_dB", none, [](S s) { return joint_loss_dB(s.scene.joint, s.light); });
  visit("loss_offset_um", none, [](S s) { return kMicro * s.light.offset.norm(); });
  visit("loss_tilt_rad", none, [](S s) { return s.light.slope.norm(); });
  // How the loop does (LoopHealth).
  visit("period_us", none, [](S s) { return kMicro * s.health.period; });
  visit("worst_period_us", none, [](S s) { return kMicro * s.health.worst; });
  visit("missed", none, [](S s) { return s.health.missed; });
  visit("passivity_J", none, [](S s) { return s.health.passivity; });
}

static_assert(kFrameColumns == [] {
  int count = 0;
  for_each_column([&](const char*, const char* endings, const auto&) {
    ++count;
    for (const char* c = endings; *c; ++c) count += *c == ' ';
  });
  return count;
}());

}  // namespace

std::vector<std::string> frame_columns() {
  std::vector<std::string> names;
  for_each_column([&](const std::string& name, const std::string& endings, const auto&) {
    for (std::size_t begin = 0; begin <= endings.size();) {
      const std::size_t end = std::min(endings.find(' ', begin), endings.size());
      names.push_back(name + endings.substr(begin, end - begin));
      begin = end + 1;
    }
  });
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
  bool slips = false;
  for (std::size_t place = 0; place < kContactPlaces; ++place) {
    const ContactState &contact = state.contact[place], &before = contact_before_[place];
    slips = slips || (!first && contact.closed && before.closed && contact.stuck != before.stuck);
  }
  contact_before_ = state.contact;
  const Shown shown = {scene_,
                       row,
                       health,
                       state,
                       forces,
                       row.segment<3>(kHandVelocity.begin).transpose() / scaling_.motion,
                       sensed_.relative().head<3>() / scaling_.force,
                       holder_force(world, result.holder).norm(),
                       contact_depths(world, contact_side(world, state.tip, state.side), state.tip),
                       slips,
                       phase_.after(state, seen),
                       light_axis(scene_.joint, state.tip)};

  Frame frame;
  float* at = frame.data();
  for_each_column([&](const char*, const char*, const auto& value) {
    const auto shows = value(shown);
    if constexpr (std::is_same_v<decltype(shows), const double>)
      *at++ = static_cast<float>(shows);
    else
      for (const double x : shows) *at++ = static_cast<float>(x);
  });
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
          {"about", scene.document().value("about", "")},
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
