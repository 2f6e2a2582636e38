#include "view/recorded.hpp"

#include <fmt/format.h>

#include <cmath>

#include "insertion/trial_setup.hpp"
#include "view/packed_rows.hpp"

namespace ferrule {
namespace {

constexpr double kAgain = 0.05;      // what comes back within this is no event of its own [s]
constexpr double kAllWithin = 0.01;  // of an event every frame is kept [s]

// A frame read by the name of a column.
float value(const Frame& frame, const char* name) {
  static const std::vector<std::string> names = frame_columns();
  for (std::size_t i = 0; i < names.size(); ++i)
    if (names[i] == name) return frame[i];
  return NAN;
}

std::string words(const char* name) {
  std::string text = name;
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

Phase phase_of(const Frame& frame) {
  return static_cast<Phase>(static_cast<int>(value(frame, "phase")));
}

// Where the end is: "34.2 um deep", "12 um before the bore".
std::string place_of(const Frame& frame) {
  const double x = value(frame, "tip_x_um");
  return x > 0 ? fmt::format("{:.1f} um before the bore", x) : fmt::format("{:.1f} um deep", -x);
}

double off_axis(const Frame& frame) {
  return std::hypot(value(frame, "tip_y_um"), value(frame, "tip_z_um"));
}

// The term that pushes hardest.
std::string strongest(const Frame& frame) {
  std::string name;
  double most = 0;
  for (const char* term : kTermNames) {
    const std::string of = term;
    const double force =
        std::hypot(value(frame, (of + "_x_uN").c_str()), value(frame, (of + "_y_uN").c_str()),
                   value(frame, (of + "_z_uN").c_str()));
    if (force > most) name = fmt::format("{} {:.1f} uN", words(term), force);
    most = std::max(most, force);
  }
  return name;
}

// Finds the events of a run as its frames come.
class EventFinder {
 public:
  explicit EventFinder(std::vector<ReplayEvent>& events) : events_(events) {}

  void operator()(const Frame& frame, std::size_t row) {
    const double t = value(frame, "t_s");
    const bool end = value(frame, "contact0_on") > 0, side = value(frame, "contact1_on") > 0;
    const Phase phase = phase_of(frame);
    begins(end_, end, t, row, "contact", [&] {
      const char* where = phase == Phase::face   ? "the face"
                          : phase == Phase::cone ? "the cone"
                                                 : "the bore";
      return fmt::format("the end touches {}, {}", where, place_of(frame));
    });
    begins(side_, side, t, row, "contact",
           [&] { return "the side touches the bore's mouth, " + place_of(frame); });
    begins(bridge_, value(frame, "bridge_on") > 0, t, row, "bridge",
           [&] { return "liquid bridges the gap, " + place_of(frame); });
    begins(slip_, value(frame, "slip_on") > 0, t, row, "slip",
           [&] { return "a contact slips, " + place_of(frame); });
    begins(jam_, phase == Phase::jammed, t, row, "jam",
           [&] { return "jammed, " + place_of(frame); });
    begins(limit_, value(frame, "force_uN") > value(frame, "limit_uN"), t, row, "limit", [&] {
      return fmt::format("the force passes the limit: {:.1f} uN", value(frame, "force_uN"));
    });
    begins(seated_, phase == Phase::seated, t, row, "seated",
           [&] { return "inserted, " + place_of(frame); });
  }

 private:
  struct Seen {
    bool on = false;
    double last = -INFINITY;  // when it was on last [s]
  };

  template <class Text>
  void begins(Seen& seen, bool on, double t, std::size_t row, const char* kind, const Text& text) {
    if (on && !seen.on && t - seen.last > kAgain) events_.push_back({row, kind, text()});
    seen.on = on;
    if (on) seen.last = t;
  }

  std::vector<ReplayEvent>& events_;
  Seen end_, side_, bridge_, slip_, jam_, limit_, seated_;
};

// What ended a run, from its last frame.
std::string reason(const ReplayRun& run, const Scene& scene, const std::string& said) {
  if (run.frames.empty())
    return "The drawn fibre does not fit into the drawn bore: no start, and no failure of anybody.";
  const Frame& last = run.frames.back();
  const double t = value(last, "t_s");
  const std::string at =
      fmt::format("{}, {:.2f} um off the axis, at {:.2f} s", place_of(last), off_axis(last), t);
  const std::string limit =
      fmt::format("the force at the holder, {:.1f} uN, passed the limit of {:.4g} uN",
                  value(last, "force_uN"), 1e6 * scene.limits.force);
  std::string text;
  switch (run.outcome) {
    case Outcome::inserted:
      text = fmt::format("Inserted: {}; a joint here would lose {:.2f} dB.", at,
                         value(last, "loss_dB"));
      break;
    case Outcome::high_loss:
      text = fmt::format(
          "Deep enough, but a joint here would lose {:.2f} dB, where {:.4g} dB is "
          "allowed: {}.",
          value(last, "loss_dB"), scene.success.loss_dB, at);
      break;
    case Outcome::force_limit:
      text = fmt::format("In the phase \"{}\" {}: {}. Strongest: {}.",
                         words(kPhases[static_cast<std::size_t>(phase_of(last))]), limit, at,
                         strongest(last));
      break;
    case Outcome::jam:
      text =
          fmt::format("Wedged, touching with end and side at once: {}; {}, tilted by {:.2f} mrad.",
                      limit, at, 1e3 * value(last, "tilt_rad"));
      break;
    case Outcome::missed:
      text = fmt::format(
          "The end landed on the front face: {:.1f} um off the axis, where the mouth "
          "has room for {:.1f} um; {} at {:.2f} s.",
          off_axis(last),
          1e6 * (scene.world.profile.mouth_radius() - scene.world.annulus.fibre_radius), limit, t);
      break;
    case Outcome::timeout:
      text = fmt::format("Time ran out: {}; {:.4g} um deep was asked for.", at,
                         1e6 * scene.success.depth);
      break;
    default:
      text = fmt::format("{}: {}.", words(name(run.outcome)), at);
      text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  }
  return said.empty() ? text : text + " It said: " + said + ".";
}

void finish(ReplayRun& run, const Scene& scene, const std::string& said) {
  run.why = reason(run, scene, said);
  if (!run.frames.empty() && run.outcome != Outcome::inserted)
    run.events.push_back({run.frames.size() - 1, "end", words(name(run.outcome))});
}

Json run_json(const ReplayRun& run, const Json& scene) {
  Json json = {{"name", run.name},
               {"outcome", name(run.outcome)},
               {"why", run.why},
               {"rows", packed_rows(run.frames)},
               {"count", run.frames.size()},
               {"events", Json::array()}};
  for (const ReplayEvent& e : run.events)
    json["events"].push_back({{"t_s", value(run.frames[e.row], "t_s")},
                              {"row", e.row},
                              {"kind", e.kind},
                              {"text", e.text}});
  if (run.scene != scene) json["scene"] = run.scene;
  return json;
}

Json to_json(const TrialMap& map) {
  Json points = Json::array();
  for (std::size_t k = 0; k < map.results.size(); ++k) {
    Json& point = points.emplace_back(Json{{"trial", k},
                                           {"y_um", std::round(1e9 * map.starts[k].x()) / 1e3},
                                           {"z_um", std::round(1e9 * map.starts[k].y()) / 1e3},
                                           {"outcome", name(map.results[k].outcome)}});
    if (map.runs[k]) point["run"] = *map.runs[k];
  }
  return {{"title", map.title}, {"command", map.command}, {"points", points}};
}

}  // namespace

ReplayRun replay_of(const Episode& episode, const Scene& scene, const std::string& run_name) {
  const EpisodeInfo& info = episode.info;
  ReplayRun run{run_name, info.outcome, {}, scene_json(scene), {}, {}};
  FrameMaker make(scene, ForceSensor(scene.sensor, info.seed, info.trial), info.period);
  EventFinder events(run.events);
  run.frames.reserve(static_cast<std::size_t>(episode.rows.rows()));
  for (Eigen::Index n = 0; n < episode.rows.rows(); ++n) {
    run.frames.push_back(make(episode.rows.row(n)));
    events(run.frames.back(), run.frames.size() - 1);
  }
  finish(run, scene, info.why);
  return run;
}

ReplayRun replay_of(const Scene& toleranced, const MakeController& make_controller,
                    std::uint64_t seed, std::uint64_t trial, const std::string& run_name,
                    double period) {
  const auto setup = trial_setup(toleranced, seed, trial);
  const Scene& scene = setup ? *setup->scene : toleranced;
  ReplayRun run{run_name, Outcome::infeasible, {}, scene_json(scene), {}, {}};
  std::string why;
  if (setup) {
    FrameMaker make(scene, setup->sensor, period);
    EventFinder events(run.events);
    const auto controller = make_controller(trial);
    const TrialResult result = run_trial(*setup, *controller, period, [&](const Tick& tick) {
      run.frames.push_back(make(make_row(tick)));
      events(run.frames.back(), run.frames.size() - 1);
      return true;
    });
    run.outcome = result.outcome;
    if (result.supervision && result.supervision->gave_up) why = name(*result.supervision->gave_up);
  }
  finish(run, scene, why);
  return run;
}

void thin(ReplayRun& run, double rate) {
  std::vector<double> event_times;
  for (const ReplayEvent& e : run.events) event_times.push_back(value(run.frames[e.row], "t_s"));
  std::vector<Frame> kept;
  double next = -INFINITY;
  std::size_t event = 0, placed = 0;  // the first that is not long over; that has no row yet
  for (std::size_t n = 0; n < run.frames.size(); ++n) {
    const double t = value(run.frames[n], "t_s");
    while (event < event_times.size() && event_times[event] < t - kAllWithin) ++event;
    const bool near = event < event_times.size() && event_times[event] <= t + kAllWithin;
    if (!near && t < next && n + 1 < run.frames.size()) continue;
    if (t >= next) next = t + 1 / rate;
    for (; placed < run.events.size() && run.events[placed].row == n; ++placed)
      run.events[placed].row = kept.size();
    kept.push_back(run.frames[n]);
  }
  run.frames = std::move(kept);
}

Json replay_json(const std::string& title, const std::vector<ReplayRun>& runs,
                 const std::vector<TrialMap>& maps) {
  const Json& scene = runs.at(0).scene;
  Json json = {{"mode", "replay"},           {"title", title},    {"scene", scene},
               {"columns", frame_columns()}, {"phases", kPhases}, {"runs", Json::array()}};
  for (const ReplayRun& run : runs) json["runs"].push_back(run_json(run, scene));
  if (maps.empty() && runs.size() == 2 && runs[0].frames.front() == runs[1].frames.front())
    json["over"] = 1;  // from one start
  if (!maps.empty()) json["maps"] = Json::array();
  for (const TrialMap& map : maps) json["maps"].push_back(to_json(map));
  return json;
}

}  // namespace ferrule
