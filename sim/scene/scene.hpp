// A scene: the world, where insertions start, what counts as success, and the two ranges that scale
// the hand to the tip. One JSON file (data/README.md describes every key); SI inside.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "sim/scene/force_sensor.hpp"
#include "sim/scene/json_fields.hpp"
#include "sim/world.hpp"

namespace ferrule {

// Where the fibre's end rests at the start of a trial: `distance` outside the bore, with normally
// distributed misalignment.
struct StartDistribution {
  double distance;        // x of the end [m], >= 0
  Vector2d lateral_mean;  // mean of y and of z [m]
  double lateral_sd;      // standard deviation of y and of z [m], >= 0
  double tilt_sd;         // standard deviation of each tilt [rad], >= 0
};

struct Limits {
  double force;  // largest force at the holder, weight apart [N], > 0
  double speed;  // largest speed commanded [m/s], > 0
  double time;   // longest trial [s], > 0
  double proof_stress = std::numeric_limits<double>::infinity();  // of bending [Pa], > 0
};

struct Success {
  double depth;  // inserted length [m], > 0
};

// Pairs of parts as they come: the fibre's diameter is normally distributed about
// fibre.diameter_um, cut at three standard deviations (where sorting ends); the bore's is uniform
// over its tolerance band.
struct Tolerance {
  double fibre_sd;             // of the diameter [m], >= 0
  double bore_low, bore_high;  // diameters [m], 0 < low <= high
};

// Ranges of (14) and (15) of the paper.
struct ScalingRanges {
  double hand_range, tip_range;  // x_s and x_m [m], > 0
  double hand_force, tip_force;  // f_s and f_m [N], > 0
};

struct Scene {
  std::string name;
  World world;
  StartDistribution start;
  std::optional<Tolerance> tolerance;
  ForceSensorModel sensor;
  Limits limits;
  Success success;
  ScalingRanges scaling;
  Json document;  // the scene as resolved: file plus settings; parsing it gives this scene again
};

// Whether an "accuracy" in the scene is applied (see plan.hpp), or checked and dropped.
enum class Planning { as_asked, none };

// Throws BadInput: "FILE: KEY = VALUE: RULE".
Scene parse_scene(const Json& document, const std::string& file,
                  Planning planning = Planning::as_asked);

// `name_or_file`: a file, or the bare name of a scene that ships with the program. `settings` are
// "dotted.key=value" with JSON values (bare words are texts); null removes a law. Throws BadInput,
// FileTrouble.
Scene load_scene(const std::string& name_or_file, const std::vector<std::string>& settings = {},
                 Planning planning = Planning::as_asked);

// One of those settings. Throws BadInput.
void apply_setting(Json& document, const std::string& setting);

// Names of the scenes that ship with the program, sorted.
std::vector<std::string> shipped_scenes();

// Changes the form of all laws of a scene document. Throws BadInput naming the laws that do not
// exist in that form (the paper prints no drag and no meniscus).
void set_form(Json& document, Form form, const std::string& file);

}  // namespace ferrule
